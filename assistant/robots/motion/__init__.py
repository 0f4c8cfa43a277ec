"""Moves that follow each other, in columns, and the poses and joints on the way between targets."""

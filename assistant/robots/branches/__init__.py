"""Arm branches and whole turns: which ones a run of moves is followed in."""

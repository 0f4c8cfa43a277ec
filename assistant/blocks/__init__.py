"""Blocks: the robot inside models of other tools, as a library of theirs or as generated code."""

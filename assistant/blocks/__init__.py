"""Blocks: the robot in models of other tools, as a library for them or as generated code."""

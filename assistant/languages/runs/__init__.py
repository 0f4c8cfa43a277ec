"""Lines that are alike, as thousands of targets and of moves are, in columns of numbers.

A language says how such a line is recognised, which columns it has and how its numbers are
printed; gathering, comparing, reading, merging and lifting of the columns stand here.
"""

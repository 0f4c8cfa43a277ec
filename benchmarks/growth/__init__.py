"""How the time of each command grows with what it reads: constructs are drawn from the grammars.

A construct is a text that grows with one number: n copies of a statement, n brackets in each other,
n times the same mistake. `growth.drawn` derives them from the rules of the grammars, the other
files list what no grammar tells. The exponent of growth is 1 where twice the text takes twice the
time, and should not be above 1.2.
"""

"""Recovery of lines that do not parse as MELFA-BASIC: the intended line, the fault, and the
cure.
"""

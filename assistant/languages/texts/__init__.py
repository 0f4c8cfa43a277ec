"""Text of any language: printed by templates, laid out, and changed in place.

A language says how its nodes are written, where words, lines and blocks of its text end, and what
belongs together; what is new is printed, and all the rest keeps its bytes.
"""

"""The layout of MELFA-BASIC texts: one for all of them, steps numbered anew, changes in place."""

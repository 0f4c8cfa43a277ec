"""Passes over a program, whichever language it comes from or goes to.

Most bring it into what a language can say; some make of kept texts what every language can say.
"""

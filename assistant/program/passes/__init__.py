"""Passes that bring a program into what a language can say, whichever language that is."""

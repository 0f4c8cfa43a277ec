"""Shared parts for reading texts with mistakes in all languages: the place, the intended text, the
cure.
"""

"""Whole tasks that are drawn: several modules whose statements cross to another language."""

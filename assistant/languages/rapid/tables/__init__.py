"""Data: words, limits and what versions differ in; read by all other rooms of the language."""

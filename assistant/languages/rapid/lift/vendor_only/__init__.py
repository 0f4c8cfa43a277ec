"""Constructs that RAPID alone has, as neutral statements for other languages."""

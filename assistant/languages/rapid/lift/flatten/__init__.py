"""Flattening: RAPID's records, optional parameters and routines by reference as plain data."""

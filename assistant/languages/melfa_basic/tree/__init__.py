"""The typed tree, and how to walk it."""

"""What the names and expressions of a file mean."""

"""What notebooks and pages show of diagrams and of their runs."""

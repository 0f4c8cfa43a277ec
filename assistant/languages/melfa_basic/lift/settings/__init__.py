"""What settings hold at each line, and the forms of procedures that they make."""

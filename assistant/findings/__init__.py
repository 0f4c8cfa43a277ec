"""What becomes of findings: the book of all rules, a project's severities, ways to print them."""

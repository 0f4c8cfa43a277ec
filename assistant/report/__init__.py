"""Pictures and pages about a program: its path over a drawing, its poses over the path."""

"""The studio: one window for the drawing, program, cell and controller of a project."""

"""Ground of all rooms: source texts, diagnostics, files, budgets, columns, rotations."""

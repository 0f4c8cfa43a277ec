"""Reading on behind syntax errors: what is damaged, what mends it, and what to say of it."""

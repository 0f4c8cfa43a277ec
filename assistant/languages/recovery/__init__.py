"""What all languages share to read texts with mistakes: where, what was meant, what to do."""

"""Known objects: shown or drawn once, found again in pictures, with what is done on them."""

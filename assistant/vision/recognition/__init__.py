"""Known objects: learnt from pictures or a drawing, recognised in pictures, and work on them."""

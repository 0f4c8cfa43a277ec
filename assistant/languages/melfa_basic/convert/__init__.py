"""From one dialect of MELFA-BASIC to another, on trees: every statement stays itself."""

"""From the trees of MELFA-BASIC files to the pseudo-program."""

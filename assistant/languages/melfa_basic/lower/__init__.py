"""An adapted pseudo-program as trees of MELFA-BASIC."""

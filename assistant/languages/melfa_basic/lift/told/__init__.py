"""What other languages are told in the place of what MELFA-BASIC alone has."""

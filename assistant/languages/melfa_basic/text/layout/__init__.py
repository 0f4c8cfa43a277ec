"""The one layout of MELFA-BASIC texts: words, and blanks between them."""

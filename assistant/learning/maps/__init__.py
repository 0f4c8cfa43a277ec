"""Extended Kohonen maps: nets that learn from pictures which joints reach what is seen."""

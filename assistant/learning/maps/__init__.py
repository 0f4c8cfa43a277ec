"""Extended Kohonen maps: nets that learn from pictures the joints for a target."""

"""Tree to text: new nodes printed, changed ones in place, one layout for `fmt`."""

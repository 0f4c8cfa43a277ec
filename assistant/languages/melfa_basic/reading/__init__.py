"""From text to the syntax tree: grammar tables, the words of a line, its nodes, a file."""

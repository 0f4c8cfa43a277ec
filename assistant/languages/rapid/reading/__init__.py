"""From text to the syntax tree: runs of alike lines into columns, the grammar for the rest."""

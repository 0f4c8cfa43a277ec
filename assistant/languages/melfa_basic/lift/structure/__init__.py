"""Where procedures, blocks and scopes begin and end in the code lines of a file."""

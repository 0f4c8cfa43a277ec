"""The extension for VS Code: made of our tables, packed without any tool of its own."""

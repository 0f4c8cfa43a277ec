"""Extension for VS Code, made from our tables and packed without a separate tool."""

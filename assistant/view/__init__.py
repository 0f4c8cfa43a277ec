"""The scene of a program in the browser: one page that plays without a server or a network."""

"""What the checks of every language share: how rules are asked, and what many of them look at."""

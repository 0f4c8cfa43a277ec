"""What is known of a program without running it: who changes what, what has a value."""

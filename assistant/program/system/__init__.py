"""What the computer does: files read with an end and replaced whole, signals, time and memory."""

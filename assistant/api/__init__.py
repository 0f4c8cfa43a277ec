"""What Python offers beside the commands: arrays as programs, checks, times, pages of notebooks."""

"""Settings made by separate statements: the value that holds at each line, and its consequences."""

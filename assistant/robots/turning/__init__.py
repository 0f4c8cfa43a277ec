"""How a tool is turned about its own axis, where that is free: along whole paths, by a search."""

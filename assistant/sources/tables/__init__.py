"""Tables of targets and waypoints: CSV, arrays, JSON, taught targets."""

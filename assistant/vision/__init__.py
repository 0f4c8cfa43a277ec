"""Vision: cameras, pointing devices, servoing, known objects; the extra `vision`."""

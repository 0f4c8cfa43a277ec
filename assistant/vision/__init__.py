"""What cameras see: cameras, pointing, servoing, known objects; the extra `vision`."""

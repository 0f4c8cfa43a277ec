"""The pseudo-program and what every room shares: frames, targets, paths, diagnostics."""

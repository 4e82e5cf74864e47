"""Facts, warnings and notes of `staffa check`."""

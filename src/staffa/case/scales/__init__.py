"""Numbers derived from a case before any run."""

"""The run directory, and fields in and out of it."""

"""Run directory on disk, and fields to and from it."""

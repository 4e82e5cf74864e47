"""Frozen records of a run: the data that rooms hand to one another and that disk keeps."""

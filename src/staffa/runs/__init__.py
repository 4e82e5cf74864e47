"""Runs of a case from start to end: one, resumed, or an ensemble; checkpoints and provenance."""

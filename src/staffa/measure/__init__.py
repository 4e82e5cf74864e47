"""Measures of a state: cracks, openings, cells, tips and forces, as numbers."""

"""Theory of columns: an even hexagonal array of sharp cracks, and its loss of stability."""

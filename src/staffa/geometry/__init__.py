"""Bodies of any shape: their outline and named parts, from Gmsh, as plain arrays."""

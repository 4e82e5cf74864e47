"""How to minimize: energies, gradients, Hessians, as functions of vectors; nothing of cracks."""

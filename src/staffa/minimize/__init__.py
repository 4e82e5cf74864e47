"""Minimization: energies, gradients and Hessians as functions of vectors, independent of cracks."""

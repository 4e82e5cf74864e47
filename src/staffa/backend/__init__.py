"""MPI, PETSc, compilers and child processes: the machine below the physics."""

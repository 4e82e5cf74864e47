"""Tests on several ranks: each starts mpiexec."""

"""Shared parts of the tests: bodies, meshes, cut runs, and the places of files."""

"""Mesh, fields and the one energy functional of them."""

"""Mesh, fields and their energy functional."""

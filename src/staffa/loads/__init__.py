"""Loads that drive a body to crack."""

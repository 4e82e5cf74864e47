"""The heat equation: what conducts, what cools, and how the temperature gets from time to time."""

"""From keys to numbers and functions."""

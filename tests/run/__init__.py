"""Tests of whole runs and of what they leave, as a user starts them."""

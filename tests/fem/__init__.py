"""Tests that build a mesh or solve on one, in this process."""

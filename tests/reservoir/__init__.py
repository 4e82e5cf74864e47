"""Tests that start the real reservoir simulator; skipped where it is absent."""

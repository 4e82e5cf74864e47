"""Two runs side by side; no finite elements."""

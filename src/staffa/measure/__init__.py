"""From a state to numbers."""

"""From a case to a problem."""

"""Numbers and tables of a finished run or ensemble; no finite elements."""

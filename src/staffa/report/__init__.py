"""From a run directory to a summary, a comparison, pictures, and a page; no finite elements."""

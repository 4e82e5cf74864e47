"""From a run directory to a summary, a comparison, pictures, and a page; no finite elements."""

import staffa.plot  # noqa: F401 - it loads Matplotlib as that is safe

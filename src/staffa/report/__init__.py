"""From a run directory to its pictures, tables and page; no finite elements."""

import staffa.plot  # noqa: F401 - it loads Matplotlib as that is safe

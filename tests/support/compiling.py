"""Plugins of the environment are looked up once a process, not six times for each compiled form.

For each form setuptools reads the files of all installed packages, in search of plugins. That is
half of what Python does to compile a form: 0.11 s of CPU without this, 0.055 s with it.
"""

from functools import cache
from importlib import metadata

metadata.entry_points = cache(metadata.entry_points)

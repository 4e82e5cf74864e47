"""The terminal that everything is printed to."""

import sys

from rich.console import Console

# A pipe has no width; rich would take 80 columns and wrap every table.
out = Console(highlight=False, width=None if sys.stdout.isatty() else 120)

"""Chromium, in which pages are opened and clicked through."""

import os
import shutil

import pytest


def chromium() -> str | None:
    """Return the path of Chromium: the one in STAFFA_CHROMIUM, or on the path; None for none."""
    return os.environ.get("STAFFA_CHROMIUM") or shutil.which("chromium")


needs_chromium = pytest.mark.skipif(
    not chromium(),
    reason="no chromium: `apt-get install chromium`, or name one in STAFFA_CHROMIUM",
)

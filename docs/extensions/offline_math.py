"""Formulas by MathJax as files of the site, so that no browser asks for them elsewhere."""

import shutil
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

PACKAGE = "sphinx-mathjax-offline"  # MathJax 3.2.2, Apache License 2.0
SCRIPT, FONTS = "tex-chtml.js", "output/chtml/fonts/woff-v2"


def copy_mathjax(app: Sphinx) -> None:
    """Copy the script and its fonts to where the pages look for them."""
    found = find_spec(PACKAGE)
    if found is None or app.builder.format != "html":
        return
    source = Path(str(found.submodule_search_locations[0])) / "static" / "mathjax"
    target = Path(app.outdir) / "_static" / "mathjax"
    (target / FONTS).mkdir(parents=True, exist_ok=True)
    shutil.copy(source / SCRIPT, target / SCRIPT)
    shutil.copytree(source / FONTS, target / FONTS, dirs_exist_ok=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Make MathJax part of the site; without its menu, which would load more."""
    app.config.mathjax_path = f"mathjax/{SCRIPT}"
    app.config.mathjax3_config = {"options": {"enableMenu": False}}
    app.connect("builder-inited", copy_mathjax)
    return {"parallel_read_safe": True}

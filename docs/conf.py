"""Settings of the site of the documentation: `make docs` builds it into build/docs."""

import os
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extensions"))
# Cells of notebooks call staffa and mpiexec as a terminal does.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])

project = "staffa"
author = "the staffa developers"
project_copyright = author
version = release = installed_version("staffa")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "notebook_times",
    "offline_math",
    "own_reference",
]
exclude_patterns = ["pictures", "cluster", "extensions", "static"]
smartquotes = False  # quotes are part of what is typed

# Links within the site: a name that is not found is an error, and so is a missing heading.
nitpicky = True
# Types of libraries, and of modules that this site does not describe.
nitpick_ignore_regex = [("py:(class|exc)", ".*")]
linkcheck_timeout = 20
linkcheck_retries = 2

myst_enable_extensions = ["amsmath", "attrs_block", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
myst_dmath_double_inline = True

# Notebooks are executed by each build, in folders that are deleted afterwards.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 120  # seconds a cell
nb_merge_streams = True

autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "sphinx_book_theme"
html_title = "staffa"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_use_index = False  # the search finds more
html_domain_indices = False
html_show_search_summary = False  # it would fetch pages, which no browser does for files
html_last_updated_fmt = None
html_theme_options = {
    "show_navbar_depth": 1,
    "show_toc_level": 2,
    "use_download_button": False,
    "use_fullscreen_button": False,
    "navigation_with_keys": True,
    "navbar_persistent": [],  # the search box stands in the sidebar
}
html_context = {"default_mode": "auto"}  # light or dark, as the reader's system is

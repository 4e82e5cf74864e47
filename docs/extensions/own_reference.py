"""Directives of this site: the keys of a case, the command line, and the Python objects.

Each is made from the program when the site is built, so that it cannot differ from it.
"""

import inspect
import re
from collections.abc import Callable
from pydoc import locate
from typing import Any

from case_keys import keys_page
from command_line import commands_page
from docutils import nodes
from docutils.statemachine import StringList
from pydantic import BaseModel
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import staffa

# Classes of which the objects are that these functions take or return.
MORE = ("staffa.io.run_directory.Run", "staffa.records.step.Step")


def objects_page() -> str:
    """Return directives that read the docstrings of the public objects, and of what they return."""
    public = [f"staffa.{name}" for name in staffa.__all__]
    lines = ["```{eval-rst}"]
    for name in (*public, *MORE):
        found = locate(name)
        if not inspect.isclass(found):
            lines += [f".. autofunction:: {name}", ""]
        elif issubclass(found, BaseModel):  # its arguments are the keys of a case, on their page
            members = ", ".join(["model_config", *found.model_fields])
            lines += [
                f".. autoclass:: {name}()",
                "   :members:",
                f"   :exclude-members: {members}",
                "",
            ]
        else:
            lines += [f".. autoclass:: {name}", "   :members:", ""]
    return "\n".join([*lines, "```"])


def directive(page: Callable[[], str]) -> type[SphinxDirective]:
    """Return a directive that puts Markdown in its place.

    Parameters
    ----------
    page : returns the Markdown.
    """

    class Generated(SphinxDirective):
        """Markdown that the program gives."""

        def run(self) -> list[nodes.Node]:
            """Return the nodes of that Markdown."""
            node = nodes.section()
            node.document = self.state.document
            lines = StringList(page().splitlines(), source=str(self.env.docname))
            self.state.nested_parse(lines, 0, node, match_titles=True)
            return node.children

    return Generated


def separate_types(app: Sphinx, kind: str, name: str, thing: Any, options: Any, lines: Any) -> None:
    """Give "name : words" of a docstring the form in which words are no type.

    Parameters
    ----------
    app, kind, name, thing, options : see Sphinx's event autodoc-process-docstring.
    lines : lines of the docstring, changed in place.
    """
    found: list[str] = []
    for line in lines:
        entry = re.fullmatch(r"(\s*)([\w*][\w*, ]*) : (.+)", line)
        found += [entry[1] + entry[2], f"{entry[1]}    {entry[3]}"] if entry else [line]
    if kind in ("attribute", "property"):  # else a colon in the first line would end a type
        found.insert(0, "")
    lines[:] = found


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the directives, and read docstrings as this project writes them."""
    for name, page in {
        "case-keys": keys_page,
        "commands": commands_page,
        "python-objects": objects_page,
    }.items():
        app.add_directive(name, directive(page))
    app.connect("autodoc-process-docstring", separate_types, priority=400)  # before napoleon
    return {"parallel_read_safe": True}

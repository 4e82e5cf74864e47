"""The files of a checkout, and places in them."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path


@dataclass(frozen=True)
class Offender:
    """A place that a measure counts.

    Parameters
    ----------
    path
        The file, relative to the root.
    line
        Its line, from 1.
    what
        What stands there.
    """

    path: str
    line: int
    what: str


@dataclass(frozen=True)
class Tree:
    """A checkout of the project.

    Parameters
    ----------
    root
        Its folder.
    """

    root: Path

    def files(self, tops: list[str], ending: str) -> list[Path]:
        """Return the files of an ending below some folders, or among some files.

        Parameters
        ----------
        tops
            Folders and files, relative to the root; what does not exist is left out.
        ending
            ".py" for instance.
        """
        found = {path for top in tops for path in (self.root / top).rglob(f"*{ending}")}
        found |= {self.root / top for top in tops if top.endswith(ending)}
        return sorted(path for path in found if path.is_file())

    def code(self, tops: list[str]) -> Iterator[tuple[Path, ast.Module]]:
        """Yield the modules below some folders, with their syntax trees."""
        for path in self.files(tops, ".py"):
            yield path, parsed(path)

    def at(self, path: Path, line: int, what: str) -> Offender:
        """Return a place of this tree.

        Parameters
        ----------
        path
            The file, absolute.
        line
            Its line, from 1.
        what
            What stands there.
        """
        return Offender(path.relative_to(self.root).as_posix(), line, what)


@cache
def parsed(path: Path) -> ast.Module:
    """Return the syntax tree of a module, read once."""
    return ast.parse(path.read_text(encoding="utf-8"))

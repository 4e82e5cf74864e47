"""Measure the language and the addresses of the code, and refuse what breaks a bound.

.venv/bin/python tools/measure_code.py                    a table of all numbers
.venv/bin/python tools/measure_code.py --list headlines   each offender, as path:line
"""

import argparse
import ast
import re
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from floors import files as files_of_floors
from floors import pointing_up
from prose import HEADLINE, long_sentences, refused
from source_tree import Offender, Tree

PACKAGE = "src/staffa"
CODE = ["src", "tests", "tools", "bench", "benchmarks", "verification", "docs"]
DOCS = [
    *("README.md", "CONTRIBUTING.md", "SECURITY.md", "docs", "tests", "bench", "benchmarks"),
    "verification",
]

# File names that may occur twice, each with its reason: a name says what a file knows together
# with its room, and a second name would say it worse.
TWICE: dict[str, str] = {}
# Files in which refused words may stand, each with its reason.
OLD_WORDS = {
    "tools/prose.py": "it lists them",
    "tests/scripts/test_measure_code.py": "it tries them",
    "docs/reference/glossary.md": "it names the words that are not used",
}
LINES_OF_FILE = 350  # what a reader holds in mind, and two screens of an editor
LINES_OF_FUNCTION = 40  # one screen, without the docstring: that one is to be complete
FROM_PARAMETERS = 3  # one or two parameters are said by the headline


Function = ast.FunctionDef | ast.AsyncFunctionDef
# The offenders, and the number of all things that were looked at.
Found = tuple[list[Offender], int]


def headlines(tree: Tree) -> Found:
    """Find docstrings whose headline is neither an imperative nor a noun phrase."""
    found, count = [], 0
    for path, module in tree.code(CODE):
        for node in ast.walk(module):
            if isinstance(node, ast.Module | ast.ClassDef | Function):
                text = ast.get_docstring(node)
                count += text is not None
                if text and HEADLINE.match(text):
                    line = getattr(node, "lineno", 1)
                    found.append(tree.at(path, line, text.splitlines()[0]))
    return found, count


def idioms(tree: Tree) -> Found:
    """Find words that are refused, in code and docs."""
    found = []
    paths = [path for end in (".py", ".toml") for path in tree.files(CODE, end)]
    paths += tree.files(DOCS, ".md")
    for path in paths:
        if path.relative_to(tree.root).as_posix() not in OLD_WORDS:
            text, markdown = path.read_text(encoding="utf-8"), path.suffix == ".md"
            for line, words, better in refused(text, markdown):
                found.append(tree.at(path, line, f"{words}: write {better}"))
    return found, len(paths)


def sentences(tree: Tree) -> Found:
    """Find sentences of the docs that are too long."""
    found = []
    paths = tree.files(DOCS, ".md")
    for path in paths:
        for line, count, begin in long_sentences(path.read_text(encoding="utf-8")):
            found.append(tree.at(path, line, f"{count} words: {begin} ..."))
    return found, len(paths)


def _public_functions(node: ast.Module | ast.ClassDef) -> Iterator[Function]:
    """Yield the public functions of a module, and those of its public classes."""
    for part in node.body:
        if isinstance(part, Function) and not part.name.startswith("_"):
            yield part
        elif isinstance(part, ast.ClassDef) and not part.name.startswith("_"):
            yield from _public_functions(part)


def _parameters(function: Function) -> list[str]:
    args = function.args
    named = [arg.arg for arg in (*args.posonlyargs, *args.args, *args.kwonlyargs)]
    named += [arg.arg for arg in (args.vararg, args.kwarg) if arg]
    return [name for name in named if name not in ("self", "cls")]


def _names(text: str, parameter: str) -> bool:
    """Return whether a docstring names a parameter: as a word, or as an entry if it is "a"."""
    if parameter in ("a", "A", "I"):
        lines = [line.strip() for line in text.splitlines()]
        return f"`{parameter}`" in text or any(line.split(" :")[0] == parameter for line in lines)
    return re.search(rf"\b{parameter}\b", text) is not None


def parameters(tree: Tree) -> Found:
    """Find public functions whose docstring leaves out a parameter."""
    found, count = [], 0
    for path, module in tree.code([PACKAGE]):
        for function in _public_functions(module):
            names = _parameters(function)
            if len(names) < FROM_PARAMETERS:
                continue
            count += 1
            text = ast.get_docstring(function) or ""
            left_out = [name for name in names if not _names(text, name)]
            if left_out:
                said = f"{function.name} does not say {', '.join(left_out)}"
                found.append(tree.at(path, function.lineno, said))
    return found, count


def _by_name(tree: Tree) -> dict[str, list[Path]]:
    found = defaultdict(list)
    for path in tree.files([PACKAGE], ".py"):
        if path.name != "__init__.py":
            found[path.name].append(path)
    return {name: paths for name, paths in found.items() if len(paths) > 1}


def file_names(tree: Tree) -> Found:
    """Find file names that occur twice; each counts once."""
    twice = _by_name(tree)
    found = []
    for paths in twice.values():
        rooms = ", ".join(sorted(path.parent.name for path in paths))
        found.append(tree.at(paths[0], 1, f"in {rooms}"))
    return found, len(tree.files([PACKAGE], ".py"))


def names_without_reason(tree: Tree) -> Found:
    """Find file names that occur twice and have no reason in `TWICE`."""
    twice = _by_name(tree)
    found = [tree.at(paths[0], 1, name) for name, paths in twice.items() if name not in TWICE]
    return found, len(twice)


def names_in_one_room(tree: Tree) -> Found:
    """Find file names that occur twice within one top room."""
    package, found = tree.root / PACKAGE, []
    for paths in _by_name(tree).values():
        rooms = [path.relative_to(package).parts[0] for path in paths]
        found += [
            tree.at(path, 1, f"again in {room}/")
            for path, room in zip(paths, rooms, strict=True)
            if rooms.count(room) > 1
        ]
    return found, len(tree.files([PACKAGE], ".py"))


def _public_twice(tree: Tree, kind: type | tuple[type, ...]) -> Found:
    places = defaultdict(list)
    for path, module in tree.code([PACKAGE]):
        for node in module.body:
            if isinstance(node, kind):
                name: str = node.name  # type: ignore[attr-defined]
                if not name.startswith("_"):
                    places[name].append(tree.at(path, node.lineno, name))
    twice = [found for found in places.values() if len({place.path for place in found}) > 1]
    others = [
        Offender(found[0].path, found[0].line, f"{found[0].what}, also in {_elsewhere(found)}")
        for found in twice
    ]
    return others, len(places)


def _elsewhere(places: list[Offender]) -> str:
    return ", ".join(f"{place.path}:{place.line}" for place in places[1:])


def classes(tree: Tree) -> Found:
    """Find names of public classes that occur in two files; each counts once."""
    return _public_twice(tree, ast.ClassDef)


def functions(tree: Tree) -> Found:
    """Find names of public functions that occur in two files; each counts once."""
    return _public_twice(tree, (ast.FunctionDef, ast.AsyncFunctionDef))


def long_files(tree: Tree) -> Found:
    """Find files of the package that are too long."""
    found, paths = [], tree.files([PACKAGE], ".py")
    for path in paths:
        count = len(path.read_text(encoding="utf-8").splitlines())
        if count > LINES_OF_FILE:
            found.append(tree.at(path, count, f"{count} lines"))
    return found, len(paths)


def long_functions(tree: Tree) -> Found:
    """Find functions of the package whose code, without the docstring, is too long."""
    found, count = [], 0
    for path, module in tree.code([PACKAGE]):
        for node in ast.walk(module):
            if isinstance(node, Function):
                count += 1
                lines = (node.end_lineno or node.lineno) - node.lineno + 1
                if ast.get_docstring(node) is not None:
                    text = node.body[0]
                    lines -= (text.end_lineno or text.lineno) - text.lineno + 1
                if lines > LINES_OF_FUNCTION:
                    found.append(tree.at(path, node.lineno, f"{node.name}: {lines} lines"))
    return found, count


def imports_up(tree: Tree) -> Found:
    """Find imports that do not point down (tools/floors.py)."""
    package = tree.root / PACKAGE
    paths = files_of_floors(package)
    found = [
        tree.at(path, line, said) for path in paths for line, said in pointing_up(path, package)
    ]
    return found, len(paths)


@dataclass(frozen=True)
class Measure:
    """A number of the code, and its bound.

    Parameters
    ----------
    find
        Finds the offenders; its name is that of the measure.
    text
        What is measured.
    most
        Most offenders that are allowed: a number, or a share in % of all that is looked at.
    share
        Whether `most` is a share.
    """

    find: Callable[[Tree], Found]
    text: str
    most: float
    share: bool = False

    def value(self, found: Found) -> float:
        """Return the number of offenders, or their share in %."""
        offenders, count = found
        return 100 * len(offenders) / max(count, 1) if self.share else len(offenders)

    def holds(self, found: Found) -> bool:
        """Return whether the bound holds."""
        return self.value(found) < self.most if self.share else self.value(found) <= self.most


MEASURES = [
    Measure(headlines, "docstring headlines that begin What, Where, How, ...", 0),
    Measure(idioms, "words that the glossary refuses, in code and docs", 0),
    Measure(sentences, "sentences of more than 40 words in README and docs", 0),
    # A name that says all, as of x, y and z, may stay unsaid in one function of ten.
    Measure(parameters, "functions of 3 or more parameters that leave one unnamed", 10, share=True),
    # A name may be right in two rooms; more of them, and a search by name finds the wrong file.
    Measure(file_names, "file names that occur twice", 6),
    Measure(names_without_reason, "of these, without a reason in tools/measure_code.py", 0),
    Measure(names_in_one_room, "file names that occur twice within one top room", 0),
    Measure(classes, "public class names in two files", 0),
    Measure(functions, "public function names in two files", 0),
    Measure(long_files, f"files over {LINES_OF_FILE} lines in the package", 0),
    # Some lists of calls are plainer in one piece.
    Measure(long_functions, f"functions over {LINES_OF_FUNCTION} lines", 1, share=True),
    Measure(imports_up, "imports that point up", 0),
]


def table(tree: Tree) -> bool:
    """Print all numbers beside their bounds; return whether every bound holds."""
    holds = True
    for measure in MEASURES:
        found = measure.find(tree)
        value, kept = measure.value(found), measure.holds(found)
        holds &= kept
        unit, sign = ("%", "<") if measure.share else ("", "<=")
        shown = f"{value:.1f} %" if measure.share else f"{value:.0f}"
        bound = f"{sign} {measure.most:g}{' ' * bool(unit)}{unit}"
        state = "" if kept else "  BROKEN"
        print(f"{measure.find.__name__:21}{shown:>8}  {bound:8}{measure.text}{state}")
    return holds


def main() -> int:
    """Print the table or the offenders of one measure; return 1 where a bound is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    known = {measure.find.__name__: measure.find for measure in MEASURES}
    parser.add_argument("--list", choices=known, metavar="NAME", help=", ".join(known))
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parent.parent)
    asked = parser.parse_args()
    tree = Tree(asked.root)
    if asked.list is None:
        return 0 if table(tree) else 1
    for offender in known[asked.list](tree)[0]:
        print(f"{offender.path}:{offender.line}: {offender.what}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

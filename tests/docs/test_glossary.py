"""docs/reference/glossary.md is a law that does not contradict itself, and names what there is."""

import re

from support.paths import DOCS, ROOT

PAGE = (DOCS / "reference" / "glossary.md").read_text(encoding="utf-8")
SOURCE = ROOT / "src" / "staffa"
# Names of equations, and names that a user gives.
FREE = {
    "NAME",
    "left",
    "hole",
    "sigma",
    "e_th",
    "A",
    "t",
    "s",
    "mu",
    "G",
    "p",
    "a1",
    "file",
    "name",
}


def rows() -> list[list[str]]:
    """Return the cells of each term: term, symbol, unit, meaning, words not to write."""
    lines = [line for line in PAGE.splitlines() if line.startswith("| ")]
    found = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [cells for cells in found if len(cells) == 5 and cells[0] not in ("term", "---")]


def test_a_term_has_one_row_and_a_meaning() -> None:
    terms = [term for row in rows() for term in row[0].split(", ")]
    assert len(terms) > 150, f"only {len(terms)}: does the test still see them?"
    assert not {term for term in terms if terms.count(term) > 1}
    assert not [row[0] for row in rows() if len(row[3].split()) < 3]


def test_no_term_is_a_word_not_to_write() -> None:
    terms = {term for row in rows() for term in row[0].split(", ")}
    refused = {word for row in rows() for word in row[4].split(", ")}
    assert not terms & refused


def test_every_symbol_is_a_name_of_the_package() -> None:
    texts = [path.read_text(encoding="utf-8") for path in SOURCE.rglob("*.py")]
    texts += [path.stem for path in SOURCE.rglob("*.py")]
    known = set(re.findall(r"\w+", " ".join(texts)))
    for row in rows():
        names = {
            word for code in re.findall(r"`([^`]+)`", row[1]) for word in re.findall(r"\w+", code)
        }
        gone = {name for name in names if not name.isdigit()} - known - FREE
        assert not gone, f"{row[0]}: the package has no {gone}"

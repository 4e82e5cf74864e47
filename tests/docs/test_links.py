"""Outside links: `make linkcheck` asks for them; their form is read here, without a network."""

import re
from collections import defaultdict
from urllib.parse import urlsplit

import pytest

from support.paths import ROOT

PAGES = sorted([*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md")])
# A link of Markdown; an address may have pairs of round brackets, as DOIs of Elsevier do.
LINK = re.compile(r"\]\((https?://(?:[^\s()]|\([^\s()]*\))+)\)")
# A prefix of the registry and the publisher's name of the paper (DOI Handbook, 2.2), which ends in
# a letter, a digit, or a bracket that was opened.
DOI = re.compile(r"10\.\d{4,9}/[A-Za-z0-9.()/_;-]*[A-Za-z0-9)]")


def links() -> dict[str, list[str]]:
    """Return the addresses of all links, with the paragraphs or entries of lists that have them."""
    found = defaultdict(list)
    for page in PAGES:
        for entry in re.split(r"\n(?=\s*[-*|] |\s*\n)", page.read_text(encoding="utf-8")):
            for address in LINK.findall(entry):
                found[address].append(" ".join(entry.split()))
    return dict(found)


LINKS = links()
PAPERS = {address: said for address, said in LINKS.items() if "doi.org" in address}


def test_there_are_papers_among_the_links() -> None:
    assert len(PAPERS) >= 11


@pytest.mark.parametrize("address", sorted(LINKS))
def test_a_link_is_an_address_over_https(address: str) -> None:
    parts = urlsplit(address)
    assert parts.scheme == "https" and re.fullmatch(r"[a-z0-9-]+(\.[a-z0-9-]+)+", parts.netloc)


@pytest.mark.parametrize("address", sorted(PAPERS))
def test_a_link_to_a_paper_is_a_doi(address: str) -> None:
    parts = urlsplit(address)
    assert parts.netloc == "doi.org" and not parts.query and not parts.fragment
    name = parts.path.removeprefix("/")
    assert DOI.fullmatch(name), name
    assert name.count("(") == name.count(")")


@pytest.mark.parametrize("address", sorted(PAPERS))
def test_a_paper_is_cited_alike_wherever_it_is(address: str) -> None:
    """Its year, volume and pages, whatever else an entry says of it."""
    told = {tuple(sorted(re.findall(r"\b\d{2,}\b", said.split("[doi]")[0]))) for said in
            PAPERS[address]}  # fmt: skip
    assert len(told) == 1, PAPERS[address]


def test_two_papers_have_two_dois() -> None:
    entries = defaultdict(set)
    for address, said in PAPERS.items():
        for one in said:
            entries[one.split("[doi]")[0].strip()].add(address)
    assert all(len(addresses) == 1 for addresses in entries.values()), entries

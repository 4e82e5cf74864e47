"""The language of the project: headlines, refused words, and sentences that are too long."""

import re
from collections.abc import Iterator

# A headline is an imperative or a noun phrase, not the answer to a question that nobody asked.
HEADLINE = re.compile(r"(What|Where|How|Whether|Those|Of)\b")
LONGEST = 40  # words in a sentence: an engineer reads it once

# What is refused, and the field's own word in its place. Words of the same table that plain
# English needs as well (answer, resist, pass, piece, exchange, clock, cut, held, moved, mode,
# section) are left to the reader.
REFUSED = {
    r"roughness A": "structural tensor",
    r"(discrete toughness|toughness factors?)": "effective Gc",
    r"keepers?": "checkpoint",
    r"cautions?": "warnings",
    r"survey(s|ed)?": "mesh inspection",
    r"class Held": "Dirichlet",
    r"class Inflow": "Neumann",
    r"class Film": "Robin",
    r"class Bath": "fluid-filled crack",
    r"respond(s|ed|ing)?": "solve K u = f",
    r"unbalanced": "projected gradient",
    r"on the space(?! V)": "on the space V, by its name",
    r"on the cone": "in the cone of admissible rates",
    r"crests?": "ridge",
    r"made-up solutions?": "manufactured solution",
    r"straight between": "linear interpolation",
    r"the cold(?=[,.;:)]|$| (is|has|goes|comes|reaches|runs|of|in|from|to|at|and)\b)": (
        "thermal boundary layer"
    ),
    r"far side": "opposite boundary",
    r"mend(s|ed|ing)?": "fix",
    r"anew": "again",
    r"begun": "started",
    r"at hand": "current",
    r"of (its|their) own": "its",
    r"so many": "as many",
    r"was not solved for": "solve failed",
}
# Names of records, which run directories hold; as words they are refused in the docs.
NAMES = {
    r"standing": "restart state",
    r"healing": "irreversibility violation",
    r"efforts?": "solver statistics",
}


# Words of one expression may be parted by the end of a line, in a comment too.
def _pattern(words: str) -> re.Pattern[str]:
    return re.compile(rf"\b{words}(?!\w)".replace(" ", r"(?: +|\n *(?:# *)?)"), re.I | re.M)


_REFUSED = [(_pattern(words), better) for words, better in REFUSED.items()]
_NAMES = [(_pattern(words), better) for words, better in NAMES.items()]
_CODE = re.compile(r"```.*?```|``?[^`\n]+``?", re.DOTALL)
# Ends of words that end no sentence.
_ABBREVIATION = re.compile(r"\b(e\.g|i\.e|cf|vs|et al|Eqs?|Figs?|Sects?|no|approx)\.$")
_END = re.compile(r"[.!?][)\"'*_`]*(?=\s|$)")
_INLINE = [
    (re.compile(r"!\[[^\]]*\]\([^)]*\)"), " "),  # a picture is no text
    (re.compile(r"\[([^\]]*)\]\([^)]*\)"), r"\1"),  # of a link, its text
    (re.compile(r"<[^<>\s][^<>]*>"), " "),
    (re.compile(r"``?[^`]+``?|\$[^$]+\$"), "code"),  # a piece of code is a word
]


def refused(text: str, markdown: bool) -> Iterator[tuple[int, str, str]]:
    """Yield each refused expression: line, counted from 1, words, what to write.

    Parameters
    ----------
    text
        The text of a file.
    markdown
        True for a page of the docs, whose code is left out; False for Python.
    """
    if markdown:
        text = _CODE.sub(lambda code: "\n" * code.group(0).count("\n"), text)
    for pattern, better in (*_REFUSED, *(_NAMES if markdown else [])):
        for found in pattern.finditer(text):
            line = text.count("\n", 0, found.start()) + 1
            yield line, " ".join(found.group(0).split()), better


def long_sentences(markdown: str) -> Iterator[tuple[int, int, str]]:
    """Yield the line, the number of words and the begin of each sentence that is too long."""
    for line, block in _blocks(markdown):
        for sentence in _sentences(block):
            count = sum(any(c.isalnum() for c in word) for word in sentence.split())
            if count > LONGEST:
                yield line, count, " ".join(sentence.split()[:6])


def _sentences(block: str) -> Iterator[str]:
    for pattern, text in _INLINE:
        block = pattern.sub(text, block)
    begin = 0
    for end in _END.finditer(block):
        if not _ABBREVIATION.search(block[begin : end.start() + 1]):
            yield block[begin : end.end()]
            begin = end.end()
    yield block[begin:]


def _blocks(markdown: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each paragraph, item of a list, heading and cell of a table."""
    fence, begin, lines = "", 0, list[str]()
    for number, line in enumerate(markdown.splitlines(), start=1):
        bare = line.strip()
        mark = re.match(r"```+|~~~+", bare)
        starts = re.match(r"(#+|[-*+]|\d+[.)]|>)\s", bare)
        if lines and (not bare or mark or starts or bare.startswith("|")):
            yield begin, " ".join(lines)
            lines = []
        if mark:
            fence = "" if fence and bare.startswith(fence) else fence or mark.group(0)
        elif fence:
            continue
        elif bare.startswith("|"):
            yield from ((number, cell) for cell in bare.strip("|").split("|"))
        elif bare:
            begin = begin if lines else number
            lines.append(bare[starts.end() :] if starts else bare)
    if lines:
        yield begin, " ".join(lines)

"""Authors and license of a case, as a research object has them."""

import re
from collections.abc import Iterable
from typing import Any

NAMED = re.compile(r"(?P<name>[^<>]+?)(?:\s*<(?P<link>[^<>\s]+)>)?")
ORCID = re.compile(r"(?:https://orcid\.org/)?(\d{4}-\d{4}-\d{4}-\d{3}[\dX])")
MAIL = re.compile(r"[^@\s<>]+@[^@\s<>]+")
SPDX = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+-]*")
NO_LICENSE = "No license is given: ask the authors before you use these files."


def is_author(text: str) -> bool:
    """Return True for a name, with an ORCID or a mail address in angle brackets or without."""
    found = NAMED.fullmatch(text.strip())
    link = found and found["link"]
    return bool(found and (not link or ORCID.fullmatch(link) or MAIL.fullmatch(link)))


def people_of(authors: Iterable[str]) -> list[dict[str, Any]]:
    """Return the authors, as the case names them, as entities of RO-Crate; each of them once."""
    found: dict[str, dict[str, Any]] = {}
    for number, text in enumerate(dict.fromkeys(map(str.strip, authors)), 1):
        person = _person(text, f"#person-{number}")
        found.setdefault(person["@id"], person)
    return list(found.values())


def _person(text: str, known_as: str) -> dict[str, Any]:
    found = NAMED.fullmatch(text)
    name, link = (found["name"], found["link"] or "") if found else (text, "")
    orcid = ORCID.fullmatch(link)
    if orcid:
        return {"@id": f"https://orcid.org/{orcid[1]}", "@type": "Person", "name": name}
    person: dict[str, Any] = {"@id": known_as, "@type": "Person", "name": name}
    return person | ({"email": link} if link else {})


def is_license(text: str) -> bool:
    """Return True for an identifier of SPDX, the address of a license, or nothing."""
    return not text or text.startswith("https://") or bool(SPDX.fullmatch(text))


def license_of(text: str) -> dict[str, Any] | str:
    """Return a license as an entity of RO-Crate, or a sentence where there is none.

    Parameters
    ----------
    text : an identifier of SPDX like "CC-BY-4.0", or an address.
    """
    if not text:
        return NO_LICENSE
    address = text if "://" in text else f"https://spdx.org/licenses/{text}"
    return {"@id": address, "@type": "CreativeWork", "name": text}

"""Scripts, pictures and data within a page, and the policy that allows its own scripts alone."""

from base64 import b64encode
from functools import cache
from hashlib import sha256
from importlib.resources import files
from pathlib import Path

# Nothing is loaded, and of scripts only those of staffa run, each known by its SHA-256: what else
# is on a page may come from anyone.
BASE = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src"


@cache
def scripts() -> tuple[str, str]:
    """Return the scripts of a page: the library that draws curves, and staffa's own."""
    from plotly.offline import get_plotlyjs  # takes a fifth of a second to load

    own = files("staffa.report").joinpath("templates/page.js").read_text(encoding="utf-8")
    return str(get_plotlyjs()), own


@cache
def policy() -> str:
    """Return the Content-Security-Policy of a page."""
    digests = (sha256(script.encode()).digest() for script in scripts())
    return " ".join([BASE, *(f"'sha256-{b64encode(digest).decode()}'" for digest in digests)])


def embedded_image(form: str, content: bytes) -> str:
    """Return an image as an address that holds all of it.

    Parameters
    ----------
    form : "png", "gif" or "webp".
    content : content of its file.
    """
    return f"data:image/{form};base64,{b64encode(content).decode()}"


def embedded_file(picture: Path) -> str:
    """Return a file of a picture, a PNG or a GIF, as an address that holds all of it."""
    return embedded_image(picture.suffix[1:], picture.read_bytes())

"""Headless Chromium, for tests that open pages as a reader does."""

from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit

from playwright.sync_api import Browser, Page, sync_playwright

from support.chromium import chromium

HERE = ("", "127.0.0.1", "localhost")  # of a URL: a file, or this machine
DESKTOP, PHONE = (1280, 900), (390, 844)  # width and height, pixels


@contextmanager
def browser() -> Iterator[Browser]:
    """Start Chromium, and end it."""
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        try:
            yield started
        finally:
            started.close()


@contextmanager
def page_of(started: Browser, size: tuple[int, int] = DESKTOP, **more: str) -> Iterator[Page]:
    """Open an empty page; at its end the test fails if it asked other machines, or met an error.

    Parameters
    ----------
    started : the browser.
    size : width and height of the page (pixels).
    more : other options of playwright's `new_page`, such as color_scheme="dark".
    """
    page = started.new_page(viewport={"width": size[0], "height": size[1]}, **more)  # type: ignore[arg-type]
    asked: list[str] = []
    errors: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("requestfailed", lambda request: errors.append(f"not loaded: {request.url}"))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on(
        "console",
        lambda message: errors.append(message.text) if message.type == "error" else None,
    )
    yield page
    page.close()
    elsewhere = [url for url in asked if (urlsplit(url).hostname or "") not in HERE]
    assert not elsewhere, f"a page asked other machines for {elsewhere}"
    assert not errors, errors

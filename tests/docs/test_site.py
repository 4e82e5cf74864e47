"""The site of the documentation: built strictly, opened and clicked through in a browser.

Notebooks are not executed here: `make docs` does that.
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

import staffa
from staffa.case.schema.case import Case
from staffa.case.schema.material_keys import RockKeys
from staffa.cli.commands import app
from support.browsing import DESKTOP, PHONE, browser, page_of
from support.chromium import needs_chromium
from support.paths import DOCS, ROOT

pytestmark = pytest.mark.slow
SECTIONS = ["Start", "Tutorials", "How-to", "Reference", "Theory", "Verification", "Development"]
SIZES = {"desktop": DESKTOP, "phone": PHONE}
# Text that runs into the margin of the page, outside of what scrolls by itself.
WIDTH = "document.documentElement.scrollWidth"
LOADED = "images => images.filter(image => !image.naturalWidth).map(image => image.src)"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the site, built with every warning an error."""
    folder = tmp_path_factory.mktemp("site")
    options = ["--builder", "html", "--fail-on-warning", "--keep-going", "--quiet"]
    options += [
        "-D",
        "nb_execution_mode=off",
        "-D",
        "suppress_warnings=myst-nb.lexer",
        "--doctree-dir",
        str(folder / "doctrees"),
    ]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, str(DOCS), str(folder / "html")],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": ""},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "html"


@pytest.fixture(scope="module")
def started() -> Iterator[Browser]:
    with browser() as chromium:
        yield chromium


def pages(site: Path) -> list[Path]:
    """Return the pages of the site, without the one that searches and the theme's own files."""
    found = set(site.rglob("*.html")) - set((site / "_static").rglob("*.html"))
    return sorted(found - {site / "search.html"})


def test_every_page_of_the_documentation_is_on_the_site(site: Path) -> None:
    written = {path.relative_to(DOCS).with_suffix("") for path in DOCS.rglob("*.md")}
    built = {path.relative_to(site).with_suffix("") for path in pages(site)}
    assert written == built


def test_every_section_stands_in_the_sidebar(site: Path) -> None:
    text = (site / "index.html").read_text(encoding="utf-8")
    places = [text.index(f'<span class="caption-text">{name}</span>') for name in SECTIONS]
    assert places == sorted(places)


def test_every_key_of_a_case_has_an_entry(site: Path) -> None:
    """Keys of tables within tables, too: each name stands on the page."""
    page = (site / "reference" / "keys.html").read_text(encoding="utf-8")
    told = {f"{name}.{key}" for name, key in keys_of_tables()}
    assert len(told) > 100, f"only {len(told)}: does the test still see them?"
    missing = [path for path in sorted(told) if f'id="confval-{path}"' not in page]
    assert not missing, missing
    for name, table in Case.model_json_schema()["$defs"].items():
        for key in table["properties"]:
            assert f">{key}<" in page or f".{key}" in page, f"{name}.{key}"


def keys_of_tables() -> Iterator[tuple[str, str]]:
    """Yield each table of a case with each of its keys."""
    schema = Case.model_json_schema()
    for name, node in schema["properties"].items():
        inner = node.get("$ref") or node.get("additionalProperties", {}).get("$ref")
        if inner:
            properties = schema["$defs"][inner.removeprefix("#/$defs/")]["properties"]
            region = name == "regions"  # its other keys are those of [material]
            for key in properties:
                if not (region and key in RockKeys.model_fields):
                    yield "regions.NAME" if region else name, key


def test_every_command_and_every_public_object_has_an_entry(site: Path) -> None:
    commands = (site / "reference" / "command-line.html").read_text(encoding="utf-8")
    for command in app.registered_commands:
        name = command.name or command.callback.__name__  # type: ignore[union-attr]
        assert f'id="staffa-{name}"' in commands, name
    objects = (site / "reference" / "python.html").read_text(encoding="utf-8")
    for name in staffa.__all__:
        assert f'id="staffa.{name}"' in objects, name


@needs_chromium
@pytest.mark.parametrize(("size", "scheme"), [("desktop", "light"), ("phone", "dark")])
def test_every_page_opens_from_the_disk(
    site: Path, started: Browser, size: str, scheme: str
) -> None:
    """Pictures load, formulas are set, nothing runs off the page, and no other machine is asked."""
    with page_of(started, SIZES[size], color_scheme=scheme) as page:
        for path in pages(site):
            page.goto(path.as_uri(), wait_until="load")
            wait_for_formulas(page)
            assert page.eval_on_selector_all("article img", LOADED) == [], path.name
            width = page.evaluate(WIDTH)
            assert width <= SIZES[size][0], f"{path.name} is {width} pixels wide"


def wait_for_formulas(page: Page) -> None:
    """Wait until each formula of the page is set, in fonts of the site."""
    if page.locator(".math").count():
        page.wait_for_function("window.MathJax && MathJax.startup && MathJax.startup.promise")
        page.evaluate("MathJax.startup.promise")
        assert page.locator("mjx-container").count() >= page.locator(".math").count()
        assert page.locator("mjx-merror").count() == 0
        assert page.evaluate("document.fonts.ready.then(() => document.fonts.check('1em MJXTEX'))")


@needs_chromium
def test_the_search_finds_a_word_and_its_result_opens(site: Path, started: Browser) -> None:
    with page_of(started) as page:
        page.goto((site / "index.html").as_uri())
        page.keyboard.press("Control+k")
        page.keyboard.type("residual_stiffness")
        page.keyboard.press("Enter")
        page.wait_for_url("**/search.html?q=residual_stiffness*")
        link = page.locator("#search-results li a").first
        link.wait_for(timeout=20_000)
        link.click()
        page.wait_for_load_state()
        assert "reference/keys.html" in page.url
        assert page.locator("[id='confval-damage.residual_stiffness']").count() == 1


@needs_chromium
def test_a_reader_clicks_from_the_first_page_to_the_theory(site: Path, started: Browser) -> None:
    with page_of(started) as page:
        page.goto((site / "index.html").as_uri())
        page.get_by_role("link", name="The energy", exact=True).first.click()
        page.wait_for_url("**/theory/energy.html")
        page.get_by_role("link", name="The next page").click()
        page.wait_for_url("**/theory/minimization.html")
        wait_for_formulas(page)
        page.get_by_role("link", name="means and errors").click()
        page.wait_for_url("**/how-to/ensembles.html")

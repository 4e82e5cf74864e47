"""Pages in Chromium, on a desktop and on a phone: curves, time slider, cracks in 3-D, copying."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from report.test_charts import wall
from report.test_compare import run_at
from report.test_report import BOX, drawn_run, rewritten
from staffa.compare.open_pair import read_pair
from staffa.errors import StaffaError
from staffa.io.ensemble_directory import read_ensemble
from staffa.io.run_directory import Run
from staffa.report import growing_page
from staffa.report.drawing import draw, draw_ensemble, draw_pair
from staffa.report.growing_page import growing_run
from staffa.results.crack_network import Drawing
from support.chromium import chromium, needs_chromium

pytestmark = [pytest.mark.slow, needs_chromium]
DESKTOP, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
KINDS = ("run", "solid", "ensemble", "pair")
READABLE = 4.5  # contrast of text that WCAG AA asks for
SEEN = 3.0  # contrast of the edge of a button


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A page of each kind, drawn once with few pixels and without VTK."""
    folder = tmp_path_factory.mktemp("pages")

    def nowhere(*given: Any, **more: Any) -> None:
        raise StaffaError("no renderer")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("staffa.plot.style.DPI", 40)
        patch.setattr("staffa.plot.volume.rendered", nowhere)
        members = [run_at(folder / "all" / f"seed-{seed}", scaled=False) for seed in (0, 1)]
        solid = drawn_run(folder / "solid", BOX, scaled=False)
        crack = Drawing(step=solid.steps[-1], network=wall(30))
        patch.setattr("staffa.report.drawing.networks", lambda run: ([crack], []))
        page_of_solid = draw(solid, movie=False).page
        patch.undo()
        patch.setattr("staffa.plot.style.DPI", 40)
        return {
            "run": draw(members[0]).page,
            "solid": page_of_solid,
            "ensemble": draw_ensemble(read_ensemble(folder / "all")).page,
            "pair": draw_pair(read_pair(*(one.path for one in members)), folder / "pair").page,
        }


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as started:
        yield started.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])


Open = Callable[..., Any]


@pytest.fixture
def opened(browser: Any) -> Iterator[Open]:
    """Opens a page, and in the end refuses errors, violations of its policy, and requests."""
    contexts, amiss, asked = [], [], []

    def open_page(path: Path, size: dict[str, int] = DESKTOP, **settings: Any) -> Any:
        contexts.append(browser.new_context(viewport=size, **settings))
        page = contexts[-1].new_page()
        page.on("console", lambda said: amiss.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: amiss.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert amiss == []
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_page_shows_all_and_does_not_scroll_sideways(
    kind: str, size: dict[str, int], pages: dict[str, Path], opened: Open
) -> None:
    page = opened(pages[kind], size)
    assert page.evaluate("document.documentElement.scrollWidth") == size["width"]
    assert page.locator("html").get_attribute("lang") == "en"
    levels = page.evaluate("[...document.querySelectorAll('h1, h2')].map(h => h.tagName)")
    assert levels[0] == "H1" and levels.count("H1") == 1 and len(levels) > 3
    assert page.locator("img:not([alt]), img[alt='']").count() == 0
    charts = page.locator("[data-chart]")
    assert charts.count() >= 2
    for chart in charts.all():
        assert chart.locator(".main-svg").count() > 0, chart.get_attribute("data-chart")
        assert chart.is_visible() and chart.get_attribute("aria-label")
    assert not page.locator("figure.live > .picture").first.is_visible()
    assert page.locator("[data-title*='Share']").count() == 0, "nothing goes to a server"
    labels = page.locator("[data-chart] .xtitle, [data-chart] .ytitle").all_text_contents()
    assert labels and all(re.search(r"\(.+\)$|cracks|^τ", label) for label in labels), labels


# Each label that playing shows stands for .4 s only, so the page itself writes them down.
RECORD_PLAYED = """() => {
  const when = document.getElementById("when");
  window.played = [];
  new MutationObserver(() => played.push(when.textContent)).observe(when, { childList: true });
}"""


def test_the_slider_moves_by_keyboard_and_changes_the_pictures(
    pages: dict[str, Path], opened: Open
) -> None:
    for kind in ("run", "solid"):
        page = opened(pages[kind])
        slider, shown = page.locator("#time"), page.locator("#slide-damage")
        last = shown.get_attribute("src")
        assert page.locator("#when").text_content().endswith("step 24")
        slider.focus()
        page.keyboard.press("ArrowLeft")
        assert page.locator("#when").text_content().endswith("step 20")
        assert slider.get_attribute("aria-valuetext").endswith("step 20")
        assert shown.get_attribute("src") != last
        page.keyboard.press("Home")
        assert page.locator("#when").text_content().endswith("step 0")
        assert shown.evaluate("image => image.naturalWidth") > 100
        page.evaluate(RECORD_PLAYED)
        page.locator("#play").press("Enter")
        page.wait_for_function("() => window.played.at(-1)?.endsWith('step 24')")
        assert [label.rsplit(maxsplit=1)[-1] for label in page.evaluate("played")] == [
            "4", "8", "12", "16", "20", "24",
        ]  # fmt: skip
        assert page.locator("#play").text_content() == "Play"


def middle(chart: Any) -> tuple[float, float]:
    chart.scroll_into_view_if_needed()
    box = chart.locator(".nsewdrag").first.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_a_curve_tells_its_value_and_unit_where_one_points(
    size: dict[str, int], pages: dict[str, Path], opened: Open
) -> None:
    page = opened(pages["run"], size)
    chart = page.locator("[data-chart='chart-energies-1']")
    page.mouse.move(*middle(chart))
    hover = chart.locator(".hoverlayer .hovertext, .hoverlayer .legend")
    hover.first.wait_for()
    said = " ".join(chart.locator(".hoverlayer text").all_text_contents())
    assert re.search(r"total : [\d.]+ J/m", said) and re.search(r"[\d.]+ (s|ms)", said), said


def drag(page: Any, start: tuple[float, float], by: float) -> None:
    """Drag by some pixels to the right, one frame a move: a slow machine sees each move."""
    x, y = start
    page.mouse.move(x, y)
    page.mouse.down()
    for part in range(1, 11):
        page.mouse.move(x + by * part / 10, y)
        page.evaluate("() => new Promise(requestAnimationFrame)")
    page.mouse.up()


def test_a_curve_is_zoomed_by_a_box_and_goes_back(pages: dict[str, Path], opened: Open) -> None:
    page = opened(pages["run"])
    chart = page.locator("[data-chart='chart-energies-1']")
    x, y = middle(chart)
    width = """chart => {
      const [a, b] = document.querySelector(chart)._fullLayout.xaxis.range; return b - a; }"""
    chosen = "[data-chart='chart-energies-1']"
    whole = page.evaluate(width, chosen)
    drag(page, (x - 60, y), by=120)
    page.wait_for_function(
        f"([chart, whole]) => ({width})(chart) < .5 * whole", arg=[chosen, whole]
    )
    page.mouse.dblclick(x, y)
    page.wait_for_function(
        f"([chart, whole]) => Math.abs(({width})(chart) / whole - 1) < 1e-6", arg=[chosen, whole]
    )


def test_the_cracks_of_a_solid_can_be_turned(pages: dict[str, Path], opened: Open) -> None:
    page = opened(pages["solid"])
    scene = page.locator("[data-chart='chart-network-1']")
    scene.scroll_into_view_if_needed()
    eye = "chart => chart._fullLayout.scene._scene.getCamera().eye"
    before, here = scene.evaluate(eye), "document.querySelector('[data-chart=chart-network-1]')"
    turned = f"before => Math.abs(({eye})({here}).x - before) > .1"
    for _ in range(20):  # a slow machine may not have drawn, or placed, the scene at the first one
        box = scene.bounding_box()
        drag(page, (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2), by=150)
        if page.evaluate(turned, before["x"]):
            break
    page.wait_for_function(turned, arg=before["x"])
    titles = scene.evaluate(
        "c => ['x', 'y', 'z'].map(n => c._fullLayout.scene[n + 'axis'].title.text)"
    )
    assert titles == ["x (m)", "y (m)", "z (m)"]


def test_a_table_a_case_and_a_command_are_copied(pages: dict[str, Path], opened: Open) -> None:
    page = opened(pages["run"])
    page.evaluate("document.body.append(document.createElement('textarea'))")

    def copied(name: str) -> str:
        page.get_by_role("button", name=name).click()
        page.get_by_role("button", name=name).get_by_text("Copied").wait_for()
        area = page.locator("textarea")
        area.fill("")
        area.focus()
        page.keyboard.press("Control+V")
        return str(area.input_value())

    table = copied("Copy the table Spacing by depth, at the last step")
    assert table.splitlines()[0].split("\t") == ["depth (m)", "cracks", "spacing (m)"]
    assert table.splitlines()[1].split("\t")[:2] == ["0.1", "16"]
    assert copied("Copy the command") == "mpiexec -n 2 staffa run case.toml --out ../again"
    page.locator("summary").click()
    assert copied("Copy Case") == (pages["run"].parent / "case.toml").read_text()


def luminance(color: str) -> float:
    channels = [int(color[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_and_curves_are_seen_in_the_light_and_in_the_dark(
    scheme: str, pages: dict[str, Path], opened: Open
) -> None:
    page = opened(pages["run"], color_scheme=scheme)

    def color(name: str) -> str:
        found = page.evaluate(
            f"getComputedStyle(document.documentElement).getPropertyValue('--{name}').trim()"
        )
        return found if len(found) == 7 else "#" + "".join(2 * letter for letter in found[1:])

    back = color("back")
    assert (luminance(back) < 0.1) == (scheme == "dark")
    for name in ("ink", "soft", "alarm"):
        assert contrast(color(name), back) >= READABLE, name
    assert contrast(color("ink"), color("tint")) >= READABLE
    assert contrast(color("edge"), back) >= SEEN


DRAWN = """[...document.querySelectorAll('[data-chart]')].flatMap(chart => [
    ...chart.data.flatMap(({opacity, line, marker}) => [line, marker].map(
        part => [part?.color, opacity ?? 1])),
    ...chart.layout.shapes.map(shape => [shape.line.color, 1]),
]).filter(([color]) => color)"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("kind", ["run", "ensemble", "pair"])
def test_each_line_and_the_edge_of_each_band_is_seen(
    kind: str, scheme: str, pages: dict[str, Path], opened: Open
) -> None:
    """Also those that are thin and let the page through in the pictures."""
    page = opened(pages[kind], color_scheme=scheme)
    back = "#16181b" if scheme == "dark" else "#ffffff"
    lines = page.evaluate(DRAWN)
    assert lines and {opacity for _, opacity in lines} == {1}
    assert min(contrast(line, back) for line, _ in lines) >= SEEN
    texts = page.evaluate(
        "[...document.querySelectorAll('[data-chart]')]"
        ".flatMap(chart => chart.layout.annotations.map(note => note.font.color))"
    )
    assert all(contrast(text, back) >= READABLE for text in texts)


HINTS = """[...document.querySelectorAll('.wide')].filter(one => one.checkVisibility()).map(one => [
    one.scrollWidth > one.clientWidth + 1, !one.nextElementSibling.hidden,
    one.classList.contains('before'), one.classList.contains('after')])"""


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_wider_than_a_phone_says_so_and_fades_where_more_is(
    kind: str, pages: dict[str, Path], opened: Open
) -> None:
    page = opened(pages[kind], PHONE)
    page.wait_for_function(f"() => ({HINTS}).every(([wide, told]) => wide === told)")
    found = page.evaluate(HINTS)
    assert any(wide for wide, *_ in found), "nothing is wide: the test sees nothing"
    assert all((wide, told, False, wide) == tuple(one) for one in found for wide, told, *_ in [one])
    page.evaluate("document.querySelectorAll('.wide').forEach(one => one.scrollTo(1e6, 0))")
    page.wait_for_function(
        f"() => ({HINTS}).every(([wide, , before, after]) => before === wide && !after)"
    )
    wide = page.locator(".wide.before").first
    mask = wide.evaluate("one => getComputedStyle(one).maskImage")
    assert mask.startswith("linear-gradient(to right, rgba(0, 0, 0, 0)"), mask
    hint = page.locator(".hint:visible").first
    assert "wider than the" in hint.text_content()
    desktop = opened(pages[kind])
    desktop.wait_for_function(f"() => ({HINTS}).every(([wide, told]) => wide === told)")


def test_without_scripts_a_page_shows_pictures_and_tables(
    pages: dict[str, Path], opened: Open
) -> None:
    page = opened(pages["run"], PHONE, java_script_enabled=False)
    pictures = page.locator("figure img")
    assert pictures.count() >= 5 and all(picture.is_visible() for picture in pictures.all())
    assert page.locator("table").first.is_visible()
    assert not page.locator(".chart").first.is_visible() and not page.locator("#play").is_visible()


HOSTILE = "</script><script>document.title='canary'</script><img src=x onerror=document.title=1>"


def test_names_within_curves_run_nothing(tmp_path: Path, opened: Open) -> None:
    """Try it also without the policy: names are escaped for HTML, JSON and Plotly."""
    run = drawn_run(tmp_path / "run")
    found = {HOSTILE: (1.0, 2.0), "<a href='javascript:document.title=1'>b</a>": (2.0, 1.0)}
    text = growing_page._run_text(
        rewritten(run, [replace(step, reactions=found) for step in run.steps]).path,
        growing_page.SlideMaker(),
        None,
    )
    (tmp_path / "open.html").write_text(re.sub(r'(Policy" content=")[^"]*', r"\1", text))
    (tmp_path / "held.html").write_text(text)
    for name in ("open", "held"):
        page = opened(tmp_path / f"{name}.html")
        legend = page.locator("[data-chart='chart-reactions-1'] .legendtext")
        assert any("onerror" in said for said in legend.all_text_contents())
        assert page.locator("[data-chart] a[*|href], [data-chart] img").count() == 0
        assert page.title() == run.manifest.title


def growing(folder: Path, steps: int) -> Run:
    """A run that goes on, after some of its steps."""
    run = drawn_run(folder)
    return rewritten(run, list(run.steps[:steps]))


def test_a_page_that_grows_is_read_again_unless_it_is_to_stay(
    tmp_path: Path, opened: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(growing_page, "SECONDS", 3)
    whole = drawn_run(tmp_path / "run")
    run = rewritten(whole, list(whole.steps[:6]))
    page_of_run = growing_run(run.path, lambda said: None)
    page_of_run.grow()
    page = opened(run.path / "report.html")
    page.get_by_text("6 of 25 steps").wait_for()
    assert page.locator("[data-chart]").count() == 4 and page.locator("#when").is_visible()
    rewritten(whole, list(whole.steps[:9]))
    page_of_run.due = 0.0
    page_of_run.grow()
    page.get_by_text("9 of 25 steps").wait_for()
    page.get_by_role("button", name="Keep it as it is").click()
    rewritten(whole, list(whole.steps))
    draw(whole)
    page.wait_for_timeout(7000)
    assert page.get_by_text("9 of 25 steps").is_visible()
    page.get_by_role("button", name="Read it again").click()
    page.get_by_text("25 of 25 steps").wait_for()
    assert page.locator("#grows").count() == 0, "it is over"


def test_a_page_that_grows_is_read_again_without_scripts(tmp_path: Path, opened: Open) -> None:
    run = growing(tmp_path / "run", 6)
    page_of_run = growing_run(run.path, lambda said: None)
    page_of_run.grow()
    text = (run.path / "report.html").read_text()
    assert '<noscript><meta http-equiv="refresh" content="10"></noscript>' in text
    page_of_run.stop()
    text = (run.path / "report.html").read_text()
    assert 'http-equiv="refresh"' not in text and "`staffa report` draws them" in text

"""Drawn runs, whole and odd ones: their pictures, their table, and their page."""

import csv
import json
import subprocess
import sys
from dataclasses import replace
from errno import EACCES
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from scipy.special import erfc

from staffa.compare.figures import FAINT, fields_figure
from staffa.errors import InputError, StaffaError
from staffa.geometry.block import SIDES
from staffa.io.own_files import write_aside
from staffa.io.run_directory import MANIFEST, STEPS, Journal, Run, create, fields_name, open_run
from staffa.io.run_progress import RunProgress, run_progress
from staffa.io.vtkhdf import VtkMesh, write_vtkhdf
from staffa.measure.generations import tracks
from staffa.measure.network import Network
from staffa.plot.cracks import COLD, FACE, cracks_figure, triangulation
from staffa.plot.curves import energies_figure, lengths_figure
from staffa.plot.ensemble_curves import counts_figure
from staffa.plot.frames import Frame, chosen, read_frames
from staffa.plot.network_openings import network_figure
from staffa.plot.style import DPI
from staffa.plot.support_forces import reactions_figure
from staffa.records.manifest import Manifest, Own
from staffa.records.status import Status
from staffa.records.step import (
    Audit,
    CellSection,
    CracksAtHeight,
    Energies,
    Heat,
    Measures,
    Return,
    SolverStatistics,
    Step,
    Tip,
)
from staffa.report.charts import charts
from staffa.report.chosen_figures import curve_figures
from staffa.report.drawing import draw
from staffa.results.columns import cells_table, columns, pooled_table
from staffa.results.slab_table import table
from staffa.results.spacing import spacing
from staffa.results.summary import summary
from staffa.results.tables import ABSENT
from support.pages import without_scripts

ELL, HEIGHTS, N = 0.04, (0.1, 0.2, 0.4), 16
TAUS = np.linspace(0.02, 0.5, 25)
SLAB, BOX = (2.5, 1.0), (1.0, 1.0, 1.0)
PLACES = (np.arange(N) + 0.5) / N


def depth_at(tau: float) -> np.ndarray:
    """Depths of the N cracks: all start at tau = .06; half stop at .14, half of the rest at .33."""
    stops = np.array([0.14 if k % 2 == 0 else 0.33 if k % 4 == 1 else np.inf for k in range(N)])
    return np.minimum(tau, stops) if tau >= 0.06 else np.zeros(0)


def drawn_manifest(size: tuple[float, ...], **changes: object) -> Manifest:
    whole = Manifest(
        version="0.1.0", commit="abc1234", created="2026-01-01T00:00:00+00:00", ranks=2,
        title="A drawn slab & its <cracks>", law="AT1", scaled=True, size=size, face="bottom",
        h=0.025, ell=ELL, L=size[-1], cells=4000, unknowns=12000, mesh="0123456789abcdef",
        toughness_factor=1.1, times=tuple(TAUS**2 / 4), taus=tuple(map(float, TAUS)),
        requested=tuple(i % 4 == 0 for i in range(len(TAUS))),
        scales={"dT": 54.0, "severity": 54.0}, versions={"dolfinx": "0.11.0"}, petsc_options={},
    )  # fmt: skip
    return replace(whole, **changes)  # type: ignore[arg-type]


def drawn_step(index: int, size: tuple[float, ...], fields: str | None) -> Step:
    tau = float(TAUS[index])
    depths = depth_at(tau)
    total = float(depths.sum())
    middle = (size[1] / 2,) if len(size) == 3 else ()
    found = [
        Tip(position=(float(p * size[0]), *middle, float(d)), depth=float(d))
        for p, d in zip(PLACES, depths, strict=False)
    ]
    sections = [
        CracksAtHeight(height=h, cracks=int((depths > h).sum()), spacing=None)
        for h in (HEIGHTS if len(size) == 2 else ())
    ]
    return Step(
        index=index, time=tau**2 / 4, tau=tau, energies=Energies(elastic=1 + tau, surface=total),
        sweeps=10 + index, status=Status.CONVERGED, reason="converged", seconds=1.5, fields=fields,
        audit=Audit(
            largest_rise=1e-12, healing=0.0, optimality=0.05, balance=2e-13, work=0.1, released=0.0
        ),
        measures=Measures(
            sections=tuple(sections), tips=tuple(found), front=float(depths.max(initial=0.0)),
            length_surface=total, length_geometry=0.95 * total,
        ),
    )  # fmt: skip


def drawn_mesh(size: tuple[float, ...], n: int) -> VtkMesh:
    """Squares or cubes of edge 1/n, points numbered along x, then y, then z."""
    counts = [round(length * n) for length in size]
    axes = [np.linspace(0, length, c + 1) for length, c in zip(size, counts, strict=True)]
    points = np.stack([a.ravel(order="F") for a in np.meshgrid(*axes, indexing="ij")], axis=1)
    number = np.arange(len(points)).reshape([c + 1 for c in counts], order="F")
    corner = number[tuple(slice(0, -1) for _ in size)].ravel(order="F")
    right, up = 1, counts[0] + 1
    square = np.column_stack([corner, corner + right, corner + right + up, corner + up])
    if len(size) == 2:
        return VtkMesh(points=np.pad(points, ((0, 0), (0, 1))), cells=square, type=9)
    layer = (counts[0] + 1) * (counts[1] + 1)
    return VtkMesh(points=points, cells=np.hstack([square, square + layer]), type=12)


def write_fields(path: Path, grid: VtkMesh, size: tuple[float, ...], tau: float) -> None:
    x, y = grid.points[:, 0], grid.points[:, len(size) - 1]
    alpha = np.zeros(len(x))
    for place, depth in zip(PLACES, depth_at(tau), strict=False):
        distance = np.hypot(x - place * size[0], np.maximum(y - depth, 0))
        alpha = np.maximum(alpha, np.clip(1 - distance / (2 * ELL), 0, 1) ** 2)
    fields = {"alpha": alpha, "T": -54 * erfc(y / tau), "u": np.zeros((len(x), 3))}
    write_vtkhdf(path, grid, fields)


def drawn_run(path: Path, size: tuple[float, ...] = SLAB, *, n: int = 16, **changes: object) -> Run:
    """A run directory as `staffa run` leaves it, of cracks whose generations are known."""
    manifest, grid = drawn_manifest(size, **changes), drawn_mesh(size, n)
    create(path, 'title = "A drawn slab"\n', manifest)
    for index in range(len(TAUS)):
        kept = manifest.requested[index]
        if kept:
            write_fields(path / fields_name(index), grid, size, float(TAUS[index]))
        Journal(path).append(drawn_step(index, size, fields_name(index) if kept else None))
    return open_run(path)


def rewritten(run: Run, steps: list[Step]) -> Run:
    """The same run directory with other records."""
    write_aside(run.path / STEPS, "")
    for step in steps:
        Journal(run.path).append(step)
    return open_run(run.path)


@pytest.fixture
def coarse(monkeypatch):
    """Pictures of few pixels, for tests that do not look at them."""
    monkeypatch.setattr("staffa.plot.style.DPI", 40)


def assert_shows_something(picture: Path) -> None:
    image = imread(picture)
    assert 1200 <= image.shape[1] <= 1600, f"{picture.name} is {image.shape[1]} pixels wide"
    assert image[..., :3].std() > 0.02, f"{picture.name} is blank"
    border = np.concatenate([image[0, :, :3], image[-1, :, :3]])
    assert border.min() > 0.9, f"{picture.name} is clipped at its upper or lower edge"


def test_the_sides_are_those_of_the_mesh():
    domain = pytest.importorskip("staffa.model.domain")
    assert domain.SIDES == SIDES


def test_the_report_loads_without_finite_elements():
    heavy = ("dolfinx", "petsc4py", "mpi4py", "pyvista", "matplotlib.pyplot")
    code = "import sys, staffa.report.drawing; print([m for m in sys.argv[1:] if m in sys.modules])"
    said = subprocess.run(
        [sys.executable, "-c", code, *heavy], capture_output=True, text=True, check=True
    )
    assert said.stdout.strip() == "[]"


def test_a_whole_run_has_all_pictures_and_a_page_with_its_numbers(tmp_path):
    run = drawn_run(tmp_path / "run")
    drawn = draw(run)
    assert [p.name for p in drawn.pictures] == ["cracks.png", "energies.png", "lengths.png"]
    assert drawn.skipped == ()
    for picture in drawn.pictures:
        assert_shows_something(picture)
    assert not list(run.path.rglob("*.staffa-part"))
    text = without_scripts(drawn.page.read_text(encoding="utf-8"))
    assert text.count("data:image/png;base64,") == 3
    assert "://" not in text, "the page is not self-contained"
    assert "A drawn slab &amp; its &lt;cracks&gt;" in text
    compared = table(run)
    assert compared is not None
    for cell in (*compared.rows[0], *compared.rows[1], *compared.rows[2]):
        assert f"<td>{cell}</td>" in text


def test_a_title_stands_above_the_line_of_a_cooled_top(tmp_path):
    run = drawn_run(tmp_path / "run")
    frames, _ = read_frames(run)
    pads = {}
    for face in ("bottom", "top"):
        manifest = replace(run.manifest, face=face, side=face)
        axes = cracks_figure(manifest, frames[:1]).axes[0]
        pads[face] = axes.titleOffsetTrans.transform((0.0, 0.0))[1]
    assert pads["top"] - pads["bottom"] >= FACE * DPI / 72


def blue_lines(manifest: Manifest, frames: list[Frame]) -> list[list[tuple[float, float]]]:
    """Ends of the lines that mark cooled faces in a picture, and the names in its legend."""
    figure = cracks_figure(manifest, frames[:1])
    return [
        [tuple(map(float, end)) for end in line.get_xydata()]  # type: ignore[misc]
        for line in figure.axes[0].lines
        if line.get_color() == COLD
    ]


def test_each_cooled_face_is_marked_and_nothing_else(tmp_path):
    run = drawn_run(tmp_path / "run")
    frames, _ = read_frames(run)
    bottom = [(0.0, 0.0), (2.5, 0.0)]
    assert blue_lines(run.manifest, frames) == [bottom]
    several = replace(run.manifest, cooled=("left", "right"))
    left, right = [(0.0, 0.0), (0.0, 1.0)], [(2.5, 0.0), (2.5, 1.0)]
    assert sorted(blue_lines(several, frames)) == sorted([bottom, left, right])
    (legend,) = cracks_figure(several, frames[:1]).legends
    assert "cooled faces" in [text.get_text() for text in legend.get_texts()]
    heated = replace(run.manifest, scales={}, cooled=("left",))
    assert blue_lines(heated, frames) == [left]
    (legend,) = cracks_figure(heated, frames[:1]).legends
    assert [text.get_text() for text in legend.get_texts()][1:3] == ["face 'bottom'", "cooled face"]
    own = {"temperature": Own(identity="a load")}
    assert blue_lines(replace(several, own=own), frames) == [], "a script's load names no face"
    (legend,) = cracks_figure(replace(several, own=own), frames[:1]).legends
    assert not [text for text in legend.get_texts() if "face" in text.get_text()]


def test_a_face_is_marked_only_where_the_body_is(tmp_path):
    """Without its cells in the middle of the bottom, the body has two parts of that face."""
    run = drawn_run(tmp_path / "run")
    (frame, *_), _ = read_frames(run)
    middles = frame.grid.points[frame.grid.cells].mean(axis=1)
    left = (np.abs(middles[:, 0] - 1.25) > 0.5) | (middles[:, 1] > 0.5)
    grid = replace(frame.grid, cells=frame.grid.cells[left])
    assert blue_lines(run.manifest, [replace(frame, grid=grid)]) == [
        [(0.0, 0.0), (pytest.approx(0.75), 0.0)],
        [(pytest.approx(1.75), 0.0), (2.5, 0.0)],
    ]


def test_forces_of_six_faces_have_six_colors_and_no_exponent_under_the_legend():
    force = {side: (1e7, 2e7, 3e7) for side in SIDES[3]}
    manifest = drawn_manifest(BOX)
    steps = [replace(drawn_step(i, BOX, None), reactions=force) for i in (0, 1)]
    (axes,) = reactions_figure(manifest, steps).axes
    assert len({line.get_color() for line in axes.lines}) == 6
    assert axes.yaxis.get_major_formatter().get_offset() == ""


def test_numbers_of_cracks_have_whole_ticks_also_where_there_are_none():
    manifest, steps = drawn_manifest(SLAB), [drawn_step(i, SLAB, None) for i in (0, 1)]
    assert not any(step.measures.tips for step in steps)
    figures = [
        lengths_figure(manifest, steps),
        counts_figure(manifest, [steps, steps]),
    ]
    for figure in figures:
        axes = next(a for a in reversed(figure.axes) if "cracks" in a.get_ylabel())
        ticks = axes.get_yticks()
        assert len(ticks) >= 2 and list(ticks) == [round(tick) for tick in ticks]
        assert axes.get_ylim()[0] == 0


def test_the_colors_of_a_difference_end_at_the_largest(tmp_path):
    run = drawn_run(tmp_path / "run")
    frames, _ = read_frames(run)
    whole = frames[-1]
    for factor, end in ((0.5, 0.5 * whole.alpha.max()), (1.0, FAINT)):
        other = replace(whole, alpha=factor * whole.alpha)
        figure = fields_figure(("one", "two"), (run.manifest,) * 2, [(whole, other)])
        assert figure.axes[2].collections[0].get_clim() == pytest.approx((-end, end))
        assert figure.axes[-1].get_xlim() == pytest.approx((-end, end))


def test_the_table_holds_the_published_and_the_drawn_numbers(tmp_path):
    compared = table(drawn_run(tmp_path / "run"))
    assert compared is not None
    header, bahr, paper, own = compared.header, *compared.rows
    assert header == ("", "p", "a0", "tau0", "a1", "tau1", "a2", "tau2", "a3", "tau3")
    assert bahr[1:] == ("0.13", "0.06", ABSENT, "0.14", "0.09", "0.35", "0.23", "0.45", "0.3")
    assert paper[1:] == ("0.15", "0.02", "0.02", "0.08", "0.05", "0.33", "0.16", "0.48", "0.25")
    cells = dict(zip(header, own, strict=True))
    assert cells["p"] == f"{2.5 / N:.3f}"
    assert (cells["a1"], cells["a2"], cells["a3"]) == ("0.14", "0.33", ABSENT)
    # The first steps, .02 apart, within ell/2 = .02 of the drawn arrests at .14 and .33.
    assert (float(cells["tau1"]), float(cells["tau2"])) == pytest.approx((0.12, 0.32), abs=0.021)
    notes = " ".join(compared.notes)
    for said in ("tau = 2 sqrt(kappa t)/L", "severity 54", "ell/L = 0.04", "4 cracks were left"):
        assert said in notes


def test_lengths_in_the_table_are_over_the_depth_of_the_body(tmp_path):
    run = drawn_run(tmp_path / "run")
    scaled = replace(run, manifest=replace(run.manifest, L=2.0))
    compared = table(scaled)
    assert compared is not None
    assert compared.rows[2][compared.header.index("a1")] == "0.07"


@pytest.mark.parametrize(
    ("size", "changes"),
    [(BOX, {}), (SLAB, {"face": None}), (SLAB, {"taus": (None,) * len(TAUS)})],
)
def test_there_is_no_table_where_it_has_no_meaning(tmp_path, size, changes):
    run = Run(path=tmp_path, case="", manifest=drawn_manifest(size, **changes), steps=())
    assert table(run) is None


def test_a_summary_names_steps_arrests_and_the_audit(tmp_path):
    facts = {fact.name: fact.text for fact in summary(drawn_run(tmp_path / "run"))}
    assert facts["status"] == "finished, 25 of 25 steps"
    assert facts["generation 1"].startswith("8 cracks stopped at depth 0.14")
    assert facts["generation 2"].startswith("4 cracks stopped at depth 0.33")
    assert [row[:2] for row in spacing(drawn_run(tmp_path / "same")).lines] == [
        ("0.1", "16"), ("0.2", "8"), ("0.4", "4"),
    ]  # fmt: skip
    assert facts["violations"] == "none"
    assert "2.0e-13" in facts["audit, worst step"]
    assert "cooled on face 'bottom'" in facts["body"] and "split" not in facts["damage"]


def test_an_audit_that_an_earlier_version_did_not_make_is_not_reported(tmp_path):
    def worst(run: Run) -> str:
        return {fact.name: fact.text for fact in summary(run)}["audit, worst step"]

    old = drawn_run(tmp_path / "run")
    record = old.steps[0].to_record()
    del record["audit"]["gap"]
    assert Step.from_record(record).audit.gap is None
    assert "gap between steps not recorded" in worst(old)
    new = [replace(step, audit=replace(step.audit, gap=3e-11)) for step in old.steps[1:]]
    assert "gap between steps 3.0e-11," in worst(replace(old, steps=tuple(new)))
    both = replace(old, steps=(old.steps[0], *new))
    assert "gap between steps 3.0e-11 (1 of 25 steps did not record it)," in worst(both)


def test_a_summary_names_the_energy_split(tmp_path):
    run = drawn_run(tmp_path / "run")
    split = replace(run, manifest=replace(run.manifest, split="no-tension"))
    told = {fact.name: fact.text for fact in summary(split)}
    assert told["damage"] == "AT1, ell = 0.04, energy split no-tension, severity 54"


def test_a_run_without_steps_has_a_page_and_no_pictures(tmp_path):
    create(tmp_path / "run", "", drawn_manifest(SLAB))
    drawn = draw(open_run(tmp_path / "run"))
    assert drawn.pictures == ()
    assert "no step is finished" in " ".join(drawn.skipped)
    assert "no step is finished yet, of 25" in drawn.page.read_text(encoding="utf-8")


@pytest.mark.usefixtures("coarse")
def test_a_run_of_one_step_shows_its_cracks_only(tmp_path):
    run = drawn_run(tmp_path / "run")
    drawn = draw(rewritten(run, [run.steps[0]]))
    assert [p.name for p in drawn.pictures] == ["cracks.png"]
    assert any("two steps" in reason for reason in drawn.skipped)


@pytest.mark.usefixtures("coarse")
def test_a_run_that_is_going_on_can_be_shown(tmp_path):
    run = drawn_run(tmp_path / "run")
    run = rewritten(run, list(run.steps[:12]))
    with (run.path / STEPS).open("a", encoding="utf-8") as file:
        file.write('{"index": 12, "time": 0.0')
    (run.path / "fields/.step-0012.vtkhdf.staffa-part").write_bytes(b"half a file")
    run = open_run(run.path)
    assert len(draw(run).pictures) == 3
    assert any("12 of 25 steps" in fact.text for fact in summary(run))


@pytest.mark.usefixtures("coarse")
def test_unmeasured_steps_have_energies_but_no_lengths(tmp_path):
    run = drawn_run(tmp_path / "run")
    run = rewritten(run, [replace(step, measures=None) for step in run.steps])
    drawn = draw(run)
    assert [p.name for p in drawn.pictures] == ["cracks.png", "energies.png"]
    assert any(reason.startswith("lengths") for reason in drawn.skipped)


@pytest.mark.usefixtures("coarse")
def test_heat_is_drawn_and_summed_up(tmp_path):
    run = drawn_run(tmp_path / "run")
    assert not [fact for fact in summary(run) if fact.name == "heat"]
    heat = Heat(
        stored=-2.0, entered={"bottom": -3.0, "source": 1.0}, imbalance=1e-12, substeps=4,
        passes=2, seconds=0.15,
    )  # fmt: skip
    run = rewritten(run, [replace(step, heat=heat) for step in run.steps])
    assert run.steps[3].heat == heat
    assert "heat.png" in [p.name for p in draw(run).pictures]
    text = {fact.name: fact.text for fact in summary(run)}
    assert text["heat"] == "stored -50; entered: bottom -75, source 25; balance 1.0e-12"
    assert text["heat steps"] == "100, 10.0% of the time, 50 passes to agree with the cracks"


@pytest.mark.usefixtures("coarse")
def test_returns_that_were_limited_are_said(tmp_path):
    run = drawn_run(tmp_path / "run")
    back = Return(index=9, time=1.0, before=2.0, found=1.5, number=3, limit=3)
    free = replace(back, limit=None)
    for returned, said in ((back, "as often as is allowed"), (free, "went back 1 times, 0 steps")):
        steps = [*run.steps[:-1], replace(run.steps[-1], returned=returned)]
        text = {fact.name: fact.text for fact in summary(replace(run, steps=tuple(steps)))}
        assert said in text["backtracking"]
    assert "allowed" not in text["backtracking"]


@pytest.mark.usefixtures("coarse")
def test_a_run_without_a_cooled_face_is_drawn_against_time(tmp_path):
    run = drawn_run(tmp_path / "run", face=None, taus=(None,) * len(TAUS), scaled=False, scales={})
    steps = []
    for step in run.steps:
        assert step.measures is not None
        bare = replace(step.measures, tips=(), sections=(), front=0.0)
        steps.append(replace(step, tau=None, measures=bare))
    run = rewritten(run, steps)
    assert len(draw(run).pictures) == 3
    assert not any(fact.name.startswith("generation") for fact in summary(run))


@pytest.mark.usefixtures("coarse")
def test_a_crackless_run_is_drawn(tmp_path):
    run = drawn_run(tmp_path / "run")
    run = rewritten(run, list(run.steps[:2]))
    assert len(draw(run).pictures) == 3
    compared = table(run)
    assert compared is not None and set(compared.rows[2][1:]) == {ABSENT}


@pytest.mark.usefixtures("coarse")
def test_what_a_later_version_adds_to_a_format_is_left(tmp_path):
    run = drawn_run(tmp_path, SLAB, n=3)
    record = json.loads((tmp_path / MANIFEST).read_text())
    (tmp_path / MANIFEST).write_text(json.dumps(record | {"weather": "fair"}))
    lines = [json.loads(line) for line in (tmp_path / STEPS).read_text().splitlines()]
    for line in lines:
        line["weather"] = line["energies"]["weather"] = line["measures"]["weather"] = "fair"
        line["measures"]["tips"] = [tip | {"weather": "fair"} for tip in line["measures"]["tips"]]
    (tmp_path / STEPS).write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    assert open_run(tmp_path) == run


def test_what_cannot_be_read_is_named(tmp_path, monkeypatch):
    drawn_run(tmp_path, SLAB, n=3)

    def denied(self, *arguments, **more):
        raise PermissionError(EACCES, "Permission denied")

    monkeypatch.setattr(Path, "read_text", denied)
    with pytest.raises(InputError, match=r"manifest\.json cannot be read \(Permission denied\)"):
        open_run(tmp_path)


def test_lost_and_damaged_fields_are_left_out_with_a_reason(tmp_path):
    run = drawn_run(tmp_path / "run")
    (run.path / fields_name(24)).write_bytes(b"no HDF5")
    (run.path / fields_name(20)).unlink()
    drawn = draw(run)
    assert drawn.pictures[0].name == "cracks.png"
    assert [reason.split()[0] for reason in drawn.skipped] == [fields_name(24)]
    for step in run.steps:
        (run.path / fields_name(step.index)).unlink(missing_ok=True)
    drawn = draw(run)
    assert [p.name for p in drawn.pictures] == ["energies.png", "lengths.png"]
    assert any(reason.startswith("cracks") for reason in drawn.skipped)


@pytest.mark.usefixtures("coarse")
def test_a_step_that_did_not_converge_and_a_violation_raise_the_alarm(tmp_path):
    run = drawn_run(tmp_path / "run")
    bad = replace(
        run.steps[7],
        status=Status.NOT_CONVERGED,
        reason="did not converge in 5000 sweeps",
        audit=replace(run.steps[7].audit, violations=("irreversibility is violated by 1e-3",)),
    )
    run = rewritten(run, [*run.steps[:7], bad])
    alarms = [fact.text for fact in summary(run) if fact.alarm]
    assert alarms == [
        "not converged at step 7, 7 of 25 steps reached: did not converge in 5000 sweeps",
        "step 7: irreversibility is violated by 1e-3",
    ]
    assert draw(run).page.read_text(encoding="utf-8").count('class="alarm"') == 2


@pytest.mark.usefixtures("coarse")
def test_a_step_that_was_not_reached_is_marked_and_in_no_result(tmp_path):
    """Its numbers are those of a state that is no solution, or of the step before."""
    run = drawn_run(tmp_path / "run", n=9)
    bad = replace(run.steps[8], status=Status.FAILED, reason="a solver failed", audit=None)
    run = rewritten(run, [*run.steps[:8], bad])
    assert bad.fields and [step.index for step in run.steps] == list(range(8))
    assert run.unreached == bad and not run.finished
    told = {fact.name: fact for fact in summary(run)}
    assert told["status"].text == "failed at step 8, 8 of 25 steps reached: a solver failed"
    assert told["not reached"].text.startswith("step 8, t = ")
    assert told["not reached"].text.endswith(f"table or picture; {bad.fields} has its last state")
    assert told["time"].text.startswith(f"t = {run.steps[7].time:g}")
    draw(run)
    tables = {
        "tips.csv": {step.index for step in run.steps if step.measures.tips},
        "network.csv": {step.index for step in run.steps if step.fields},
    }
    for name, expected in tables.items():
        with (run.path / name).open(encoding="utf-8", newline="") as file:
            assert {int(row["step"]) for row in csv.DictReader(file)} == expected != set(), name
    assert list(run.to_frame()["step"]) == list(range(8))
    assert run_progress(run.path) == RunProgress(8, 25, 8 / 25)
    curves, _ = curve_figures(run)
    for name, figure in curves.items():
        first, *others = charts(figure())
        (line,) = first["layout"]["shapes"]
        assert line["x0"] == line["x1"] > max(first["data"][0]["x"]), name
        assert first["layout"]["xaxis"]["range"][1] > line["x0"], "the mark is in sight"
        assert [note["text"] for note in first["layout"]["annotations"]] == ["step 8 not reached"]
        assert all(other["layout"]["shapes"][-1]["x0"] == line["x0"] for other in others)


def test_violations_of_a_first_step_that_was_not_reached_are_told(tmp_path):
    run = drawn_run(tmp_path / "run", n=2)
    audit = replace(run.steps[0].audit, violations=("irreversibility is violated by 1e-3",))
    bad = replace(run.steps[0], status=Status.FAILED, reason="a solver failed", audit=audit)
    told = [(fact.name, fact.text) for fact in summary(rewritten(run, [bad]))]
    assert ("violation", "step 0: irreversibility is violated by 1e-3") in told
    assert not {"audit, worst step", "violations"} & {name for name, _ in told}


def test_the_length_to_be_quoted_is_that_of_the_network(tmp_path):
    run = drawn_run(tmp_path / "run", n=9)
    run = rewritten(run, list(run.steps[:9]))
    energy = run.steps[8].measures.length_surface

    def told(run: Run = run) -> str:
        return next(fact.text for fact in summary(run) if fact.name == "crack length")

    def write(*rows: tuple[int, float]) -> None:
        lines = [f"{step},0,0,4,{length:.6g},0\n" for step, length in rows]
        table.write_text("step,time,tau,cracks,length,volume\n" + "".join(lines))

    sizes = told().removesuffix("; quote that of the network, which `staffa report` writes")
    assert "by energy" in sizes and sizes.endswith("by geometry")
    table, near = run.path / "network.csv", 0.95 * energy
    write((0, 0.0), (8, near))
    assert told() == f"{near:.4g} of the network at step 8, to be quoted; {sizes}"
    write((8, near), (30, 5.0))
    assert told().startswith(f"{near:.4g} of the network at step 8"), "the run has no step 30 now"
    write((0, 0.0), (4, near))
    assert told().startswith(sizes), "step 8 has fields too: a network of step 4 is an old one"
    for text in ("step\n", "", "step,length\n8,none\n"):
        table.write_text(text)
        assert told().startswith(sizes), "a table that cannot be read is none"
    write((4, near))
    last = rewritten(run, [*run.steps[:8], replace(run.steps[8], fields=None)])
    assert told(last).endswith(f"; at step 8 {sizes}") and " network at step 4" in told(last)


def test_a_network_that_leaves_damage_out_is_quoted_with_the_length_by_energy(tmp_path):
    run = drawn_run(tmp_path / "run", n=9)
    run = rewritten(run, list(run.steps[:9]))
    energy = run.steps[8].measures.length_surface
    header = "step,time,tau,cracks,length,volume\n"

    def told(length: float) -> str:
        (run.path / "network.csv").write_text(f"{header}8,0,0,4,{length:.6g},0\n")
        return next(fact.text for fact in summary(run) if fact.name == "crack length")

    half = f"{energy / 2:.4g} of the network at step 8, 100% off that by energy: quote both; "
    assert told(energy / 2).startswith(f"{half}the network leaves out cracks along a side")
    assert told(energy / 2).count(f"{energy:.4g} by energy") == 1
    assert "quote both; look at the picture" in told(2 * energy)
    assert told(0.0).startswith("no crack is traced in the network at step 8: the network leaves")


def test_where_no_reached_step_has_fields_no_report_can_write_the_network(tmp_path):
    run = drawn_run(tmp_path / "run", n=9)
    run = rewritten(run, [replace(step, fields=None) for step in run.steps])
    (said,) = (fact.text for fact in summary(run) if fact.name == "crack length")
    assert said.endswith("that of the network is known at steps with fields, and none was reached")


def test_what_a_run_fell_back_to_is_said(tmp_path):
    run = drawn_run(tmp_path / "run")
    assert not [fact for fact in summary(run) if fact.name == "fall-backs"]
    steps = [
        replace(step, effort=SolverStatistics(fallbacks=2, halvings=1, moves=9))
        for step in run.steps
    ]
    (said,) = (f.text for f in summary(rewritten(run, steps[:2])) if f.name == "fall-backs")
    assert said == "needed the second damage solver 4 times, a step cut in two 2 times"


def test_steps_of_the_first_version_are_read() -> None:
    """They counted how often the second damage solver took over, and nothing else."""
    record = drawn_step(0, SLAB, None).to_record()
    del record["effort"]
    assert Step.from_record(dict(record, fallbacks=3)).effort == SolverStatistics(fallbacks=3)


@pytest.mark.usefixtures("coarse")
def test_a_place_that_cannot_be_written_is_a_plain_error(tmp_path):
    run = drawn_run(tmp_path / "run")
    (run.path / "pictures").write_text("a file in the way", encoding="utf-8")
    with pytest.raises(StaffaError, match="cannot be written"):
        draw(run)


def test_five_moments_are_drawn_the_last_among_them(tmp_path):
    run = drawn_run(tmp_path / "run")
    assert [step.index for step in chosen(run)] == [4, 8, 16, 20, 24]


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
def test_cells_become_triangles_that_cover_the_body_once(kind):
    grid = drawn_mesh(SLAB, 8)
    if kind == "triangles":
        a, b, c, d = grid.cells.T
        halves = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
        grid = VtkMesh(points=grid.points, cells=halves, type=5)
    triangles = triangulation(grid, drawn_manifest(SLAB))
    x, y = triangles.x[triangles.triangles], triangles.y[triangles.triangles]
    twice = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    assert twice.min() > 0
    assert twice.sum() / 2 == pytest.approx(2.5)


@pytest.mark.slow
@pytest.mark.parametrize("face", ["top", "left", "right"])
def test_any_side_can_be_the_cooled_one(tmp_path, face):
    run = drawn_run(tmp_path / "run", face=face)
    (run.path / fields_name(0)).unlink()
    drawn = draw(rewritten(run, list(run.steps[:6])))
    assert_shows_something(drawn.pictures[0])


@pytest.mark.slow
def test_a_body_in_three_dimensions_is_rendered(tmp_path):
    run = drawn_run(tmp_path / "run", BOX)
    drawn = draw(run, movie=False)
    names = ["cracks", "sections", "energies", "lengths"]
    assert [p.name for p in drawn.pictures] == [f"{name}.png" for name in names], drawn
    for picture in drawn.pictures:
        assert_shows_something(picture)


@pytest.mark.usefixtures("coarse")
def test_without_a_renderer_only_what_it_draws_is_missing(tmp_path, monkeypatch):
    monkeypatch.setattr("staffa.plot.volume.RENDERER", "staffa.no_such_module")
    drawn = draw(drawn_run(tmp_path / "run", BOX, n=6))
    assert [p.name for p in drawn.pictures] == ["sections.png", "energies.png", "lengths.png"]
    missing = [reason.split(":")[0] for reason in drawn.skipped if "ParaView" in reason]
    assert missing == ["cracks", "growing"]


def test_depths_of_the_table_are_those_of_sharp_tips(tmp_path):
    """A run that knows how far these lie beyond the recorded ones says so, and adds it."""
    raw = table(drawn_run(tmp_path / "raw"))
    sharp = table(drawn_run(tmp_path / "sharp", tip_reach=0.03))
    assert raw is not None and sharp is not None
    cells = [dict(zip(t.header, t.rows[-1], strict=True)) for t in (raw, sharp)]
    for name in ("a0", "a1", "a2"):
        assert float(cells[1][name]) == pytest.approx(float(cells[0][name]) + 0.03, abs=1e-3)
    for name in ("p", "tau0", "tau1", "tau2"):
        assert cells[1][name] == cells[0][name]
    assert "0.75 ell beyond" in " ".join(sharp.notes), "0.03 of ell = 0.04"
    assert "as they are" in " ".join(raw.notes)


def test_no_sharp_tip_lies_beyond_the_body():
    manifest = drawn_manifest(SLAB, tip_reach=0.03)
    found = [manifest.sharp(depth) for depth in (0.0, 0.5, 0.98, 1.0)]
    assert found == pytest.approx([0.0, 0.53, 1.0, 1.0])
    steps = [drawn_step(index, SLAB, None) for index in range(N)]
    deepest = max(
        track.final for track in tracks(steps, axis=1, sharp=lambda depth, room: depth + 9.0)
    )
    assert deepest > 9 and max(
        track.final for track in tracks(steps, axis=1, sharp=replace(manifest, tip_reach=9.0).sharp)
    ) == pytest.approx(1.0)


def test_tips_are_written_crack_by_crack_and_step_by_step(tmp_path, coarse):
    run = drawn_run(tmp_path / "run", tip_reach=0.03)
    drawn = draw(run)
    assert run.path / "tips.csv" in drawn.tables
    with (run.path / "tips.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["crack", "step", "time", "tau", "x", "y", "depth"]
    assert {int(row["crack"]) for row in rows} == set(range(N))
    for row in rows:
        crack, tau = int(row["crack"]), float(row["tau"])
        assert float(row["x"]) == pytest.approx(PLACES[crack] * SLAB[0]), "one crack, one place"
        assert float(row["y"]) == pytest.approx(depth_at(tau)[crack])
        assert float(row["depth"]) == pytest.approx(depth_at(tau)[crack] + 0.03)
    assert len(rows) == N * sum(tau >= 0.06 - 1e-12 for tau in TAUS)


def test_rejected_steps_are_counted_and_stand_for_nothing(tmp_path, coarse):
    run = drawn_run(tmp_path / "run", adaptive=True)
    steps = list(run.steps)
    tried = replace(steps[5], status=Status.REJECTED, reason="cracks ran 4 ell", fields=None)
    again = rewritten(run, [*steps[:5], tried, tried, *steps[5:]])
    assert again.steps == run.steps and again.superseded == () and again.finished
    assert again.rejected == (tried, tried)
    facts = {fact.name: fact.text for fact in summary(again)}
    assert facts["status"] == "finished, 25 steps", "how many there would be was not known"
    assert facts["rejected steps"].startswith("2,")
    assert "backtracking" not in facts
    cut = rewritten(run, [*steps[:5], tried])
    assert not cut.finished and cut.steps == tuple(steps[:5])
    assert draw(cut).page.exists()


AWAY = (-1.0, 2.0, 5.0)  # where a body begins


@pytest.mark.parametrize("size", [(2.0, 1.0), (2.0, 1.0, 0.5)])
def test_a_network_is_drawn_where_its_body_is(size):
    dim = len(size)
    manifest = drawn_manifest(size, lower=AWAY[:dim])
    points = np.array([AWAY, np.add(AWAY, [1.0, 0.5, 0.2]), np.add(AWAY, [0.0, 0.5, 0.2])])
    cracks = Network(
        points=points,
        elements=np.array([range(dim)]),
        damage=np.ones(3),
        opening=np.full(3, 1e-3),
    )
    axes = network_figure(manifest, [(drawn_step(1, size, None), cracks)]).axes[0]
    drawn = [getattr(axes, f"get_{axis}lim")() for axis in "xyz"[:dim]]
    margin = 0 if dim == 2 else 0.05
    expected = [(a, a + s) for a, s in zip(AWAY, size, strict=False)]
    assert np.array(drawn) == pytest.approx(np.array(expected), abs=margin)


@pytest.mark.parametrize("size", [(2.0, 1.0), (2.0, 1.0, 0.5)])
def test_a_network_of_unknown_openings_is_gray_and_has_no_scale(size):
    dim = len(size)
    points = np.array([[0, 0, 0], [1.0, 0.5, 0.2], [0, 0.5, 0.2]])
    cracks = Network(
        points=points,
        elements=np.array([range(dim)]),
        damage=np.ones(3),
        opening=np.full(3, np.nan),
    )
    figure = network_figure(drawn_manifest(size), [(drawn_step(1, size, None), cracks)])
    (axes,) = figure.axes
    figure.draw_without_rendering()
    (drawn,) = axes.collections
    color = drawn.get_edgecolor() if dim == 2 else drawn.get_facecolor()
    assert np.ravel(color)[3] == 1.0, "it is seen"
    assert np.ptp(np.ravel(color)[:3]) == 0.0, "it is gray"


def test_a_report_on_a_run_of_an_earlier_version_keeps_its_openings(tmp_path, coarse):
    run = drawn_run(tmp_path / "run", n=64, requested=tuple(i == 24 for i in range(len(TAUS))))
    (run.path / "network").mkdir()
    kept = [run.path / "network.csv", run.path / "network" / "cracks-0004.csv"]
    for path in kept:
        path.write_text("opening\n2e-5\n")
    drawn = draw(run)
    assert [path.read_text() for path in kept] == ["opening\n2e-5\n"] * 2
    assert set(kept) <= set(drawn.tables)
    said = next(reason for reason in drawn.skipped if reason.startswith("openings: "))
    assert "earlier version" in said and said in drawn.page.read_text()


def test_a_difference_of_damage_is_drawn_where_the_bodies_are():
    manifest = drawn_manifest(SLAB, lower=AWAY[:2])
    mesh = drawn_mesh(SLAB, 2)
    grid = replace(mesh, points=mesh.points + np.array([*AWAY[:2], 0.0]))
    alpha = np.linspace(0.0, 1.0, len(grid.points))
    step = drawn_step(1, SLAB, None)
    frame = Frame(path=Path("drawn"), step=step, grid=grid, alpha=alpha, T=-alpha)
    figure = fields_figure(("a", "b"), (manifest, manifest), [(frame, frame)])
    limits = {(*axes.get_xlim(), *axes.get_ylim()) for axes in figure.axes[:3]}
    assert limits == {(-1.0, SLAB[0] - 1, 2.0, 2 + SLAB[1])}


@pytest.mark.parametrize(("loads", "lowest"), [(0.0, 0.0), (5.0, 0.0), (-50.0, -49.0)])
def test_energies_below_zero_are_seen(loads, lowest):
    steps = [drawn_step(index, SLAB, None) for index in range(3)]
    steps = [replace(s, energies=replace(s.energies, loads=loads)) for s in steps]
    bottom, _ = energies_figure(drawn_manifest(SLAB), steps).axes[0].get_ylim()
    assert bottom == 0 if lowest == 0 else bottom < lowest


def columns_of(depth: float, sides: tuple[int, ...]) -> CellSection:
    """Interior cells of unit area with these sides, and one at an end."""
    n = len(sides)
    return CellSection(
        depth=depth, pixel=(0.01, 0.01), areas=(1.0,) * n + (0.5,), perimeters=(4.0,) * n + (2.0,),
        sides=(*sides, 3), ends=(0,) * n + (1,), junctions={"T": 1, "Y": 3, "X": 0}, cracked=0.1,
    )  # fmt: skip


def cut_into_columns(run: Run, *sides: tuple[int, ...]) -> Run:
    """The run, with cells at the last step at depths 0.1, 0.2, ..."""
    last = run.steps[-1]
    cells = tuple(columns_of(0.1 * (k + 1), given) for k, given in enumerate(sides))
    ended = replace(last, measures=replace(last.measures, cells=cells))
    return rewritten(run, [*run.steps[:-1], ended])


def test_cells_are_told_by_depth(tmp_path):
    run = cut_into_columns(drawn_run(tmp_path, BOX), (6, 6, 5), (6, 7))
    found = columns([run])
    assert found.header[:5] == ("depth", "cells", "inside", "spacing", "diameter")
    assert [row[:3] for row in found.lines] == [("0.1", "4", "3"), ("0.2", "3", "2")]
    assert found.rows[1][found.header.index("sides")] == "6.5", "two tell no error"
    assert found.rows[0][found.header.index("spacing")] == "0.5"
    assert found.rows[0][found.header.index("T")] == "0.25"
    many = columns([run, run])
    assert many.rows[0][many.header.index("T")].startswith("0.25 ± ")
    assert spacing(run).lines == found.lines
    rows = list(csv.DictReader(StringIO(cells_table(run).csv())))
    assert [(row["step"], row["depth"], row["cells"]) for row in rows] == [
        ("24", "0.1", "4"), ("24", "0.2", "3"),
    ]  # fmt: skip
    assert float(rows[1]["sides"]) == 6.5 and float(rows[1]["hexagonality"]) == 0.5


def test_cells_of_several_runs_are_taken_together(tmp_path):
    one = cut_into_columns(drawn_run(tmp_path / "a", BOX), (6, 6, 5))
    other = cut_into_columns(drawn_run(tmp_path / "b", BOX), (6, 6, 6))
    assert columns([one, other]).lines[0][1:3] == ("8", "6")
    (row,) = csv.DictReader(StringIO(pooled_table([one, other]).csv()))
    assert (row["sections"], row["T"], row["Y"]) == ("2", "2", "6")
    assert float(row["hexagonality"]) == pytest.approx(5 / 6)
    (more,) = csv.DictReader(StringIO(pooled_table([one, other, one, other]).csv()))
    assert float(more["hexagonality_error"]) < float(row["hexagonality_error"])


def test_without_cells_there_is_no_table_of_them(tmp_path):
    run = drawn_run(tmp_path)
    assert columns([run]) is None and cells_table(run).rows == pooled_table([run]).rows == ()

"""Results in the case's units: terminal, page, pictures and tables of several kinds of cases."""

import csv
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from report.test_report import BOX, SLAB, cut_into_columns, drawn_manifest, drawn_run, rewritten
from staffa.case.reading.read import parse_case
from staffa.case.reading.ready_cases import ready_case
from staffa.case.scales.case_scales import derived_numbers
from staffa.case.scales.shown_units import reference, units
from staffa.display_units import Magnitudes, Unit, choose_display_units
from staffa.io.run_directory import Run, open_run
from staffa.measure.network import Network
from staffa.plot.cracks import cracks_figure
from staffa.plot.curves import energies_figure, lengths_figure
from staffa.plot.frames import read_frames
from staffa.plot.labels import clock_label, moment, tau_label
from staffa.plot.network_openings import network_figure
from staffa.plot.support_forces import reactions_figure
from staffa.records.manifest import Probe
from staffa.records.step import Energies, Fluid, Heat, OtherCracks
from staffa.report.captions import caption
from staffa.report.drawing import draw
from staffa.results.columns import cells_table
from staffa.results.crack_network import Drawing, network_table, write_networks
from staffa.results.series import probes_table, reactions_table
from staffa.results.slab_table import definitions
from staffa.results.spacing import TITLE, round_depths, spacing
from staffa.results.summary import summary
from staffa.results.tables import Table
from staffa.results.tips import tips_table
from staffa.runs.follower import Follower

NAMES = ("length", "crack", "opening", "volume", "time", "temperature", "stress", "energy", "force")
READY = {
    "glass-slab": ("mm", "mm", "µm", "mm²", "s", "°C", "MPa", "J/m", "MN/m"),
    "granite-face": ("m", "m", "µm", "mm²", "h", "°C", "MPa", "kJ/m", "MN/m"),
    "squeezed": ("m", "m", "µm", "mm²", "h", "°C", "MPa", "kJ/m", "MN/m"),
    "wellbore": ("m", "m", "µm", "mm²", "h", "°C", "MPa", "kJ/m", "MN/m"),
    "ceramic-quench": ("mm", "mm", "µm", "mm²", "ms", "°C", "MPa", "J/m", "MN/m"),
    "fracture-wall": ("m", "m", "µm", "cm²", "d", "°C", "MPa", "MJ/m", "MN/m"),
    "cell": ("",) * 9,
    "bar": ("",) * 9,
    "brick": ("",) * 9,
}


@pytest.mark.parametrize("name", READY)
def test_a_ready_case_is_shown_in_the_units_that_it_writes(name: str) -> None:
    case = ready_case(name)
    found = units(case, derived_numbers(case))
    assert tuple(found[key].name if found else "" for key in NAMES) == READY[name]


SOLID = """
domain = { size = ["4 cm", "4 cm", "2 cm"], h = "2 mm" }
material = { E = "60 GPa", nu = 0.2, Gc = "60 J/m^2", expansion = "8e-6 1/K", kappa = "1 mm^2/s" }
damage = { ell = "4 mm" }
temperature = { profile = "half-space", dT = "200 K" }
time = { t = ["1 min", "30 min"] }
"""


@pytest.mark.parametrize(
    ("setting", "name", "unit"),
    [
        ('damage.ell="5 mm"', "length", "cm"),
        ('damage.ell="5 mm"', "volume", "cm³"),
        ('damage.ell="5 mm"', "crack", "cm²"),
        ('domain.size=["40 mm","4 cm","2 cm"]', "length", "mm"),
        ('time.t=["1 min","1 hour"]', "time", "min"),
        ('time.t=["1 hour","9 days"]', "time", "d"),
        ('time.t=["3600 s"]', "time", "s"),
        ("time={tau=[0.1]}", "time", "s"),
    ],
)
def test_units_that_are_mixed_or_absent_are_chosen_by_size(
    setting: str, name: str, unit: str
) -> None:
    case = parse_case(SOLID, [setting])
    assert units(case, derived_numbers(case))[name].name == unit


def test_the_temperature_that_changes_count_from_is_known_where_it_is_one() -> None:
    assert reference(ready_case("glass-slab")) == pytest.approx(423.15)
    assert reference(ready_case("cell")) is None
    assert reference(parse_case(SOLID)) is None


def test_a_unit_counts_names_and_heads_columns() -> None:
    celsius = Unit(name="°C", size=1.0, zero=273.15)
    assert celsius.text(293.15) == "20 °C" and celsius.column("T") == "T_degC"
    force = Unit(name="kN/m", size=1e3)
    assert force.of(np.array([2e3])) == pytest.approx([2.0])
    assert (force.column("fx"), force.header("force")) == ("fx_kN_per_m", "force (kN/m)")
    assert Unit().label("x") == "x (scaled)" and Unit().column("x") == Unit().header("x") == "x"
    assert Unit(name="mm", size=1e-3).power(2).column("area") == "area_mm2"


MM = Unit(name="mm", size=1e-3)
HOURS = Unit(name="h", size=3600.0)
CELSIUS = Unit(name="°C", zero=273.15)
WRITTEN = {"length": MM, "time": HOURS, "temperature": CELSIUS}


def in_units(path: Path, size: tuple[float, ...] = SLAB, **changes: object) -> Run:
    """A drawn run whose case is written in mm, h and °C."""
    sizes = Magnitudes(extent=max(size), depth=1.0, last=1.0, energy=5e3, heat=5e6, force=5e6)
    known = {"units": vars(choose_display_units(len(size), sizes, WRITTEN)), "profile": "heat"}
    return drawn_run(path, size, n=6, scaled=False, **(known | changes))


def squeezed(path: Path) -> Run:
    """One under prestress, which carries a force."""
    run = in_units(path)
    energies = Energies(elastic=-1500.0, surface=200.0, loads=-2500.0, at_rest=1e6)
    force = {"left": (1.5e6, 0.0)}
    return rewritten(run, [replace(step, energies=energies, reactions=force) for step in run.steps])


def pulled(path: Path) -> Run:
    """A bar without a cooled face, in which nothing diffuses."""
    run = in_units(path, profile="none", face=None, scales={})
    bare = [
        replace(s, tau=None, measures=replace(s.measures, tips=(), sections=(), front=0.0))
        for s in run.steps
    ]
    return rewritten(run, bare)


def heated(path: Path) -> Run:
    """A plate that is heated: its face has no temperature drop."""
    return in_units(path, scales={"dT": 0.0, "severity": 0.0}, reference=293.15)


def told(run: Run) -> dict[str, str]:
    return {fact.name: fact.text for fact in summary(run)}


def test_a_summary_speaks_in_the_units_of_its_case(tmp_path: Path) -> None:
    found = told(in_units(tmp_path / "cooled"))
    assert found["body"] == "2500 x 1000 mm, cooled on face 'bottom', 4000 cells of 25 mm"
    assert found["damage"] == "AT1, ell = 40 mm, severity 54"
    assert found["time"] == "t = 1.736e-05 h, tau = 0.5"
    assert found["cracks"] == "16, the deepest 500 mm"
    assert found["crack length"] == (
        "4440 mm by energy, 4218 mm by geometry; quote that of the network, which `staffa report` "
        "writes"
    )
    assert found["generation 1"].startswith("8 cracks stopped at depth 140 mm, t = ")
    found = told(squeezed(tmp_path / "squeezed"))
    assert found["energies"] == (
        "elastic -1.5 since rest, surface 0.2, of loads -2.5 since rest, total -3.8 kJ/m"
    )
    assert told(heated(tmp_path / "heated"))["body"].startswith("2500 x 1000 mm, depths from face")
    assert told(pulled(tmp_path / "pulled"))["body"] == "2500 x 1000 mm, 4000 cells of 25 mm"
    block = told(in_units(tmp_path / "block", BOX))
    assert block["crack area"] == (
        "4.44e+06 mm² by energy, 4.218e+06 mm² by geometry; quote that of the network, which "
        "`staffa report` writes"
    )
    assert block["energies"].endswith(" kJ")


def test_heat_and_fluid_have_readable_units(tmp_path: Path) -> None:
    run = in_units(tmp_path)
    fluid = Fluid(pressure=2.5e6, volume=3e-6)
    heat = Heat(stored=-2e6, entered={"bottom": -2e6})
    last = run.steps[-1]
    last = replace(last, heat=heat, measures=replace(last.measures, fluid=fluid))
    found = told(replace(run, steps=(*run.steps[:-1], last)))
    assert found["heat"].startswith("stored -2 MJ/m; entered: bottom -2")
    assert found["fluid in cracks"] == "pressure 2.5 MPa, volume 3 mm²"


def test_spacing_by_depth_is_there_in_the_units_of_the_case(tmp_path: Path) -> None:
    run = in_units(tmp_path / "counted")
    found = spacing(run)
    assert found.header == ("depth (mm)", "cracks", "spacing (mm)")
    assert [row[:2] for row in found.lines] == [("100", "16"), ("200", "8"), ("400", "4")]
    scaled = spacing(drawn_run(tmp_path / "scaled", n=6))
    assert scaled.header == ("depth", "cracks", "spacing") and scaled.lines[0][0] == "0.1"
    block = spacing(cut_into_columns(in_units(tmp_path / "block", BOX), (6, 6, 5)))
    cells = dict(zip(block.header, block.lines[0], strict=True))
    assert (cells["depth (mm)"], cells["spacing (mm)"]) == ("100", "500")
    none = spacing(pulled(tmp_path / "pulled"))
    assert none.rows == () and "no flat cooled face" in none.notes[0]


def test_depths_at_which_cracks_count_are_told_apart_from_those_of_tips(tmp_path: Path) -> None:
    """A tip is sharp and lies deeper than the damage that is counted."""
    found = spacing(in_units(tmp_path / "sharp", tip_reach=0.03)).notes[1]
    assert "damage above 0.8 is a crack" in found and "lies 30 mm deeper" in found
    assert "2 ell = 80 mm of the face" in found
    assert "deeper" not in spacing(in_units(tmp_path / "raw")).notes[1]


def without_depths(run: Run) -> Run:
    last = run.steps[-1]
    last = replace(last, measures=replace(last.measures, sections=()))
    return replace(run, steps=(*run.steps[:-1], last))


def test_without_depths_of_the_case_tips_and_fields_tell_the_spacing(tmp_path: Path) -> None:
    """16 cracks 156 mm apart: 8 end at .14, 4 at .33 and 4, 625 mm apart, at .5 m."""
    found = spacing(without_depths(in_units(tmp_path / "slab")))
    assert found.lines[0] == ("100", "16", "156.2")
    assert found.lines[-1] == ("400", "4", "625") and [row[1] for row in found.lines][1] == "8"
    assert "no measures.depths" in found.notes[1]
    block = spacing(in_units(tmp_path / "block", BOX))
    assert block.header[0] == "depth (mm)" and len(block.rows) == 6
    assert "no measures.depths" in block.notes[0]
    depths = [float(row[0]) for row in block.lines]
    assert depths == pytest.approx(500 * (np.arange(6) + 0.5) / 6, rel=1e-3)


def test_cracks_of_other_faces_are_told_where_the_spacing_leaves_them_out(tmp_path: Path) -> None:
    run = without_depths(in_units(tmp_path / "slab"))
    last = run.steps[-1]
    others = (OtherCracks(face="top", cracks=2, deepest=0.1),)

    def said(face_cools: bool = True, **measured: object) -> str:
        found = replace(last.measures, others=others, **measured)
        manifest = replace(run.manifest, face_cools=face_cools)
        steps = (*run.steps[:-1], replace(last, measures=found))
        return spacing(replace(run, manifest=manifest, steps=steps)).notes[-1]

    assert said() == "Cracks that start on other cooled faces are not counted here: 2 from 'top'."
    assert said(tips=()).startswith("No spacing by depth: no crack starts on 'bottom' and leaves")
    assert said(False, tips=()).startswith("No spacing by depth: 'bottom' is not cooled")
    assert all(said(cools, tips=()).endswith("there are 2 from 'top'.") for cools in (True, False))


@pytest.mark.parametrize(
    ("deepest", "depths"),
    [(0.0, []), (0.5, [0.1, 0.2, 0.3, 0.4]), (1.9, [0.5, 1.0, 1.5]), (12.0, [5.0, 10.0])],
)
def test_round_depths_end_above_the_deepest_crack(deepest: float, depths: list[float]) -> None:
    assert round_depths(deepest) == pytest.approx(depths)


def header(table: Table) -> list[str]:
    return next(csv.reader(StringIO(table.csv())))


def test_columns_of_tables_name_their_units(tmp_path: Path) -> None:
    run = squeezed(tmp_path / "squeezed")
    assert header(tips_table(run)) == [
        "crack", "step", "time_h", "tau", "x_mm", "y_mm", "depth_mm",
    ]  # fmt: skip
    assert header(reactions_table(run)) == [
        "step", "time_h", "tau", "side", "fx_MN_per_m", "fy_MN_per_m",
    ]  # fmt: skip
    row = next(csv.DictReader(StringIO(reactions_table(run).csv())))
    assert float(row["fx_MN_per_m"]) == pytest.approx(1.5)
    block = cut_into_columns(in_units(tmp_path / "block", BOX), (6, 6, 5))
    row = next(csv.DictReader(StringIO(cells_table(block).csv())))
    assert float(row["depth_mm"]) == pytest.approx(100)
    assert float(row["area_mm2"]) == pytest.approx(1e6) and "sides_error" in row
    assert float(row["spacing_mm"]) == pytest.approx(500) and "spacing_error_mm" in row


def test_probes_tell_changes_and_temperatures(tmp_path: Path) -> None:
    probe = Probe(name="well", points=((0.5, 0.25),))
    run = in_units(tmp_path, probes=(probe,), reference=293.15)
    run = replace(run, steps=(replace(run.steps[0], probed=((-5.0, 1e-3, 2e-3, 0.5),)),))
    row = next(csv.DictReader(StringIO(probes_table(run).csv())))
    expected = {"x_mm": 500, "y_mm": 250, "T_K": -5, "temperature_degC": 15, "ux_mm": 1, "uy_mm": 2}
    assert {name: float(row[name]) for name in expected} == pytest.approx(expected)
    changes = replace(run, manifest=replace(run.manifest, reference=None))
    assert "temperature_degC" not in header(probes_table(changes))


CRACK = Network(
    points=np.array([[0.5, 0.0, 0.0], [0.5, 0.25, 0.0]]),
    elements=np.array([[0, 1]]),
    damage=np.ones(2),
    opening=np.full(2, 2e-5),
    uncertainty=np.full(2, 1e-6),
)


def test_networks_are_told_in_mm_and_micrometers(tmp_path: Path) -> None:
    run = in_units(tmp_path)
    found = [Drawing(step=run.steps[-1], network=CRACK)]
    told = network_table(run, found)
    numbers_of = dict(zip(told.header, told.lines[0], strict=True))
    assert (numbers_of["length (mm)"], numbers_of["volume (mm²)"]) == ("250", "5")
    assert numbers_of["largest opening (µm)"] == "20" and "time (h)" in numbers_of
    write_networks(run, found)
    row = next(csv.DictReader(StringIO((run.path / "network.csv").read_text())))
    assert float(row["mean_opening_um"]) == pytest.approx(20)
    assert float(row["volume_mm2"]) == pytest.approx(5)
    elements = (run.path / "network" / "cracks-0024.csv").read_text()
    row = next(csv.DictReader(StringIO(elements)))
    assert float(row["y1_mm"]) == pytest.approx(250) and float(row["opening_um"]) == pytest.approx(
        20
    )
    bar = network_figure(run.manifest, [(run.steps[-1], CRACK)]).axes[-1]
    assert bar.get_xlabel() == "opening (µm)" and bar.get_xlim() == pytest.approx((0, 20))


def test_axes_are_in_time_and_tau_is_below_where_it_has_a_meaning(tmp_path: Path) -> None:
    cooled = in_units(tmp_path / "cooled")
    axes = lengths_figure(cooled.manifest, cooled.steps).axes[-1]
    assert axes.get_xlabel() == "time (h)"
    (tau,) = axes.child_axes
    assert "tau" in tau.get_xlabel() and "erfc" not in tau.get_xlabel()
    last = cooled.steps[-1]
    assert axes.lines[-1].get_xdata()[-1] == pytest.approx(last.time / 3600)
    assert moment(cooled.manifest, last) == "t = 1.736e-05 h   (τ = 0.5)"
    bar = pulled(tmp_path / "bar")
    axes = energies_figure(bar.manifest, bar.steps).axes[0]
    assert (axes.get_xlabel(), axes.child_axes) == ("time (h)", [])
    scaled = drawn_run(tmp_path / "scaled", n=6)
    assert clock_label(scaled.manifest, scaled.steps) == tau_label(scaled.manifest)


def test_the_half_space_is_told_only_where_it_is_one() -> None:
    for profile in ("half-space", "slab", "convective", "heat", "none", ""):
        manifest = drawn_manifest(SLAB, profile=profile)
        own = profile == "half-space"
        assert ("erfc" in tau_label(manifest)) == own, profile
        assert ("erfc" in definitions(manifest)[0]) == own, profile


def test_energies_under_forces_are_changes_since_rest(tmp_path: Path) -> None:
    run = squeezed(tmp_path / "squeezed")
    axes = energies_figure(run.manifest, run.steps).axes[0]
    assert axes.get_ylabel() == "energy (kJ/m)"
    assert [line.get_label() for line in axes.lines] == [
        "total", "elastic since rest", "of the loads since rest", "surface",
    ]  # fmt: skip
    assert axes.lines[1].get_ydata()[0] == pytest.approx(-1.5)
    text = caption("energies", run.manifest, run.steps)
    assert "that of the loads are changes since the state of rest" in text
    free = in_units(tmp_path / "free")
    assert "rest" not in caption("energies", free.manifest, free.steps)
    assert reactions_figure(run.manifest, run.steps).axes[0].get_ylabel() == (
        "force on the body (MN/m)"
    )


def test_captions_are_true_for_the_current_case(tmp_path: Path) -> None:
    cooled, bar = in_units(tmp_path / "cooled"), pulled(tmp_path / "bar")
    block, hot = in_units(tmp_path / "block", BOX), heated(tmp_path / "hot")

    def said(name: str, run: Run) -> str:
        return caption(name, run.manifest, run.steps)

    assert "isotherms" in said("cracks", cooled) and "isotherms" not in said("cracks", bar)
    assert "near quarter" in said("cracks", block) and "isotherms" not in said("cracks", block)
    assert "depth" not in said("lengths", bar) and said("lengths", bar) == "Length of the cracks."
    assert said("lengths", block).startswith("Area of the cracks and depth of each tip")
    assert said("lengths", cooled).endswith("below the cooled face and how many cross each depth.")
    assert "face 'bottom'" in said("lengths", hot) and "cooled" not in said("lengths", hot)
    assert "per unit thickness" in said("energies", cooled)
    assert "thickness" not in said("energies", block)


def test_the_page_of_a_heated_plate_calls_nothing_cooled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("staffa.plot.style.DPI", 40)  # nobody looks at its pictures
    text = draw(heated(tmp_path)).page.read_text(encoding="utf-8")
    assert "depth of each tip below the face &#39;bottom&#39;" in text
    assert TITLE in text and "depth (mm)" in text and "spacing (mm)" in text
    assert "cooled face" not in text


def test_isotherms_are_temperatures_of_the_case(tmp_path: Path) -> None:
    run = heated(tmp_path / "hot")
    frames = [replace(frame, T=-frame.T) for frame in read_frames(run)[0]]  # by 54 K hotter
    labels = {text.get_text() for text in cracks_figure(run.manifest, frames).legends[0].texts}
    assert {"T = 30.8 °C", "face 'bottom'"} <= labels and "cooled face" not in labels
    other = in_units(tmp_path / "cooled")
    found = cracks_figure(other.manifest, read_frames(other)[0]).legends[0].texts
    assert {"T = T₀ −43.2 K", "cooled face"} <= {text.get_text() for text in found}


def test_the_line_of_a_step_has_units(tmp_path: Path) -> None:
    run = squeezed(tmp_path)
    follower = Follower(directory=tmp_path, speaks=False, quiet=True, manifest=run.manifest)
    line = follower._line(run.steps[-1])
    assert "t 1.736e-05 h (tau 0.5000), elastic -1.5 since rest, surface 0.2" in line
    assert "total -3.8 kJ/m" in line and "16 cracks to 500 mm" in line


def test_units_stay_with_a_run_and_old_runs_have_readable_ones(tmp_path: Path) -> None:
    run = in_units(tmp_path, reference=293.15)
    assert open_run(tmp_path).manifest == run.manifest
    old = replace(run.manifest, units={}, size=(0.04, 0.012), L=0.012, times=(90.0,))
    assert (old.shown.length.name, old.shown.time.name) == ("mm", "s")
    assert replace(old, scaled=True).shown.length.name == ""

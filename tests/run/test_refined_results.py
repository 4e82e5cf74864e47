"""A run whose mesh follows the cracks, as the user sees it: preview, log, tables, pictures."""

from pathlib import Path

import pytest
from matplotlib.image import imread

from staffa.case.check.cost import memory
from staffa.case.check.preview import preview
from staffa.case.check.refined_cells import CELLS_WITHIN, mesh_growth
from staffa.case.reading.read import parse_case
from staffa.compare.open_pair import read_pair
from staffa.compare.side_by_side import results
from staffa.io.run_directory import open_run
from staffa.results.mesh_changes import mesh_changes
from staffa.results.summary import summary
from support.commands import forked

TEXT = """
title = "refined"
[domain]
size = [1.0, 1.0]
h = 0.015625
cells = "triangle"
refine = { coarsest = "16 h" }
[material]
nu = 0.2
[damage]
ell = 0.05
[temperature]
profile = "half-space"
severity = 54.0
face = "bottom"
[toughness]
amplitude = 0.1
seed = 3
correlation_length = 0.0625
[time]
tau = [0.03, 0.06, 0.1]
[output]
at = [0.1]
"""
DEEP = ("time.tau=[0.05,0.12,0.25]", "output.at=[0.25]", "temperature.severity=30.0")
SOUND = ("temperature.severity=0.5",)  # nothing cracks: cells follow the temperature alone
UNIFORM = ("domain.refine=false", "domain.h=0.03125", "damage.allow_coarse=true", "time.tau=[0.1]")


def runs_in(folder: Path, *settings: str) -> Path:
    """Run the case with these changes; return its run directory."""
    case, directory = folder / "case.toml", folder / "run"
    case.write_text(TEXT, encoding="utf-8")
    options = [word for setting in settings for word in ("--set", setting)]
    done = forked("run", case, "--out", directory, *options, timeout=300)
    assert done.returncode == 0, done.stderr
    return directory


@pytest.fixture(scope="module")
def refined(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return runs_in(tmp_path_factory.mktemp("refined"))


@pytest.mark.slow
@pytest.mark.parametrize("settings", [(), DEEP, SOUND], ids=["strong", "deep", "sound"])
def test_check_knows_the_cells_at_the_end_within_the_factor_it_says(settings, tmp_path):
    found = mesh_growth(parse_case(TEXT, settings))
    changes = mesh_changes(open_run(runs_in(tmp_path, *settings)))
    assert found.known and found.start.cells == changes.start == 64
    ratio = found.end.cells / changes.end
    assert 1 / CELLS_WITHIN < ratio < CELLS_WITHIN, f"{found.end.cells} of {changes.end}"
    assert changes.end < found.most.cells / 2


def test_check_tells_cells_at_the_start_and_the_end_and_counts_those_of_the_end():
    refined, uniform = parse_case(TEXT), parse_case(TEXT, ["domain.refine=false"])
    facts = {name: (value, meaning) for name, value, meaning in preview(refined).facts}
    assert facts["cells, start"][0] == "about 64"
    growth = mesh_growth(refined)
    assert facts["cells, end"][0] == f"about {growth.end.cells:,}"
    assert f"{growth.most.cells:,} if all were h long" in facts["cells, end"][1]
    assert facts["unknowns, end"][0].endswith(f" + {growth.end.vertices:,}")
    assert growth.most.cells == mesh_growth(uniform).end.cells == 16384
    assert memory(refined) < memory(uniform)


def test_where_only_a_run_can_tell_the_end_is_bounded_by_the_uniform_mesh():
    case = parse_case(TEXT, ["damage.law=AT2"])
    growth = mesh_growth(case)
    assert not growth.known and growth.end == growth.most
    facts = {name: (value, meaning) for name, value, meaning in preview(case).facts}
    assert facts["cells, end"][0] == "at most 16,384"
    assert facts["cells, end"][1].startswith("only the run can tell")


def test_a_body_that_nothing_cracks_stays_coarse_but_for_its_temperature():
    sound, cracked = (parse_case(TEXT, [f"temperature.severity={s}"]) for s in (0.5, 54.0))
    ends = [mesh_growth(case).end.cells for case in (sound, cracked)]
    assert 64 < ends[0] < ends[1] / 2, ends


def test_the_edge_that_check_reads_is_that_of_the_finest_cells():
    """Eight cells of .125 along each side, no longer than 8 h = .131, are halved three times."""
    case = parse_case(TEXT, ["domain.h=0.0164", 'domain.refine={coarsest="8 h"}'])
    assert case.domain.halvings == 3 and case.outline.h == 1 / 64


@pytest.mark.slow
def test_the_log_tells_the_cells_when_they_change(refined):
    steps, told = open_run(refined).steps, 0
    first = (refined / "run.log").read_text().splitlines()[0]
    assert first.startswith("refined: 123 unknowns at the start, 3 steps")
    lines = [line for line in (refined / "run.log").read_text().splitlines() if "sweeps" in line]
    for step, line in zip(steps, lines, strict=True):
        assert (f", {step.mesh.cells:,} cells" in line) == (step.mesh.cells != told)
        told = step.mesh.cells


@pytest.mark.slow
def test_summary_and_frame_tell_the_growth_of_the_mesh(refined):
    run = open_run(refined)
    changes, facts = mesh_changes(run), {fact.name: fact.text for fact in summary(run)}
    assert facts["mesh"].startswith(f"64 cells at the start, {changes.end:,} at the end; split ")
    assert "largest damage in a coarse cell 0" in facts["mesh"]
    assert facts["body"].endswith("cells of 0.015625 at cracks, else longer")
    frame = run.to_frame()
    assert frame["mesh_cells"].tolist() == [step.mesh.cells for step in run.steps]
    assert frame["mesh_changes"].sum() == changes.times > 3
    assert changes.energy == frame["mesh_energy"].sum() < 0, "a finer mesh is softer"


@pytest.mark.slow
def test_the_picture_of_the_mesh_is_drawn_with_its_caption(refined):
    image = imread(refined / "pictures" / "mesh.png")
    assert image[..., :3].std() > 0.02, "it is blank"
    page = (refined / "report.html").read_text(encoding="utf-8")
    assert page.count("The cells at the last time whose fields are kept, over the damage") == 2


@pytest.mark.slow
def test_compare_tells_the_cells_of_a_refined_and_a_uniform_run(refined, tmp_path):
    uniform = runs_in(tmp_path, *UNIFORM)
    rows = {row[0]: row[1:3] for row in results(read_pair(refined, uniform)).rows}
    end = mesh_changes(open_run(refined)).end
    assert rows["cells of the mesh, start"] == ("64", "4096")
    assert rows["cells of the mesh, end"] == (str(end), "4096")
    assert rows["largest damage in a coarse cell"][1] == "0"
    assert not (uniform / "pictures" / "mesh.png").exists()

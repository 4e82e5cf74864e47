"""Ensembles of seeds: their statistics, their directory, their page, and real ones of a slab."""

import csv
import shutil
from dataclasses import replace
from math import sqrt
from pathlib import Path
from statistics import mean, stdev

from staffa.backend.stack import MPI

import pytest

from case.test_bad_input import check_sentence, files_in, sentence_of, staffa
from report.test_report import BOX, SLAB, assert_shows_something, drawn_run, rewritten
from staffa.backend.lock import Lock
from staffa.case.reading.read import parse_case
from staffa.case.schema.toml_text import to_toml
from staffa.display_units import Magnitudes, Unit, choose_display_units
from staffa.errors import InputError, SolveError
from staffa.geometry.block import face_axis
from staffa.io.ensemble_directory import Ensemble, is_ensemble, read_ensemble
from staffa.io.own_files import write_aside
from staffa.io.run_directory import CASE, STEPS, open_run
from staffa.measure.averages import Average, average, mean_over_time
from staffa.measure.generations import arrests
from staffa.records.status import Status
from staffa.report.drawing import draw_ensemble
from staffa.results.ensemble_means import facts, sheets
from staffa.results.member_numbers import with_left_out
from staffa.results.tables import Table
from staffa.runs.ensemble import ensemble_members, member, seeds_from, started_members
from staffa.runs.member_runs import run_members
from staffa.setup.build import problem
from support.pages import without_scripts

SMALL = """title = "A small slab"
[domain]
size = [1.6, 0.8]
h = 0.04
[damage]
ell = 0.06
[toughness]
amplitude = 0.1
seed = 3
[temperature]
severity = 20.0
[time]
tau = [0.1, 0.2, 0.4]
[measures]
depths = [0.1, 0.2]
"""


# ---- numbers ------------------------------------------------------------------------------------


def test_the_average_is_of_those_that_have_the_number() -> None:
    found = average([1.0, None, 2.0, 6.0])
    assert found.members == 3 and found.mean == 3.0
    # s^2 = (4 + 1 + 9)/2 = 7
    assert found.error == pytest.approx(sqrt(7 / 3), rel=1e-14), f"error {found.error}"


def test_one_member_has_a_mean_without_an_error_and_none_has_neither() -> None:
    assert average([None, 4.0]) == Average(mean=4.0, error=None, members=1)
    assert average([None]) == average([]) == Average(mean=None, error=None, members=0)


def test_a_state_lasts_until_the_next_step_and_is_unknown_outside_the_run() -> None:
    found = mean_over_time([((1.0, 3.0, 5.0), (0, 2, 4)), ((2.0, 4.0, 6.0), (5, 1, 7))])
    assert found.at.tolist() == [2.0, 3.0, 4.0, 5.0]
    assert found.values.tolist() == [[0, 2, 2, 4], [5, 5, 1, 1]]
    assert found.mean.tolist() == [2.5, 3.5, 1.5, 2.5]
    assert found.error == pytest.approx([2.5, 1.5, 0.5, 1.5])  # of two: half their difference


# ---- drawn ensembles ----------------------------------------------------------------------------


def drawn_ensemble(folder: Path, size: tuple[float, ...] = SLAB, **changes: object) -> Ensemble:
    """Three members, of the seeds 0, 1, 2.

    A seed more is a crack more at each depth, and a length that is larger by a tenth of the first.
    """
    for seed in range(3):
        run = drawn_run(folder / f"seed-{seed}", size, n=6, **changes)
        write_aside(run.path / CASE, f'title = "drawn"\n[toughness]\nseed = {seed}\n')
        steps = []
        for step in run.steps:
            m = step.measures
            assert m is not None
            more = [replace(s, cracks=s.cracks + seed * (s.cracks > 0)) for s in m.sections]
            longer = (1 + 0.1 * seed) * m.length_surface
            more_m = replace(m, sections=tuple(more), length_surface=longer)
            steps.append(replace(step, measures=more_m))
        rewritten(run, steps)
    return read_ensemble(folder)


def column(sheet: Table, name: str) -> Average:
    """Mean, error and number of members of a column, in its unit."""
    k = sheet.header.index(name)
    mean, error, members = (sheet.columns[k].shown(row[k]) for row in sheet.totals)
    return Average(mean=mean, error=error, members=members)


def numbers(sheet: Table) -> list[list[object]]:
    """The numbers of each member, in their units."""
    names = sheet.columns[1:]
    return [[c.shown(n) for c, n in zip(names, row[1:], strict=True)] for row in sheet.rows]


def test_a_drawn_ensemble_has_the_numbers_of_its_members(tmp_path) -> None:
    network, end = sheets(drawn_ensemble(tmp_path))
    assert network.header == ("seed", "p", "a0", "tau0", "a1", "tau1", "a2", "tau2")
    # 16 cracks on a width of 2.5; half of them stop at a depth of .14, half of the rest at .33.
    assert column(network, "p").mean == pytest.approx(2.5 / 16)
    assert column(network, "a1") == Average(mean=pytest.approx(0.14), error=0.0, members=3)
    assert column(network, "a2").mean == pytest.approx(0.33)
    assert end.header[1:] == ("cracks at 0.1", "cracks at 0.2", "cracks at 0.4", "front", "length")
    assert [row[2] for row in numbers(end)] == [4, 5, 6]
    deep = column(end, "cracks at 0.4")
    assert (deep.mean, deep.members) == (5.0, 3) and deep.error == pytest.approx(1 / sqrt(3))
    lengths = [row[-1] for row in numbers(end)]
    assert lengths == pytest.approx([lengths[0], 1.1 * lengths[0], 1.2 * lengths[0]])
    assert column(end, "length").error == pytest.approx(0.1 * lengths[0] / sqrt(3))


def test_its_page_holds_the_table_and_pictures_that_show_something(tmp_path) -> None:
    drawn = draw_ensemble(drawn_ensemble(tmp_path))
    assert [p.name for p in drawn.pictures] == ["counts.png", "growth.png"] and not drawn.skipped
    for picture in drawn.pictures:
        assert_shows_something(picture)
    text = without_scripts(drawn.page.read_text(encoding="utf-8"))
    assert text.count("data:image/png;base64,") == 2 and "://" not in text
    assert "<th>τ<sub>2</sub></th>" in text and "<th>cracks at 0.4</th>" in text
    assert "<td>mean</td><td>17</td><td>9</td><td>5</td>" in text
    assert "<td>error</td><td>0.58</td><td>0.58</td><td>0.58</td>" in text
    assert "standard error of the mean, s/sqrt(n)" in text
    assert not list(tmp_path.rglob("*.staffa-part"))


@pytest.fixture
def coarse(monkeypatch):
    """Pictures of few pixels, for tests that do not look at them."""
    monkeypatch.setattr("staffa.plot.style.DPI", 40)


def test_members_may_be_solved_and_kept_in_other_ways_and_differ_in_nothing_else(tmp_path) -> None:
    drawn_ensemble(tmp_path)
    file = tmp_path / "seed-1" / CASE
    text = file.read_text()
    file.write_text(text + "[solver]\nsweeps = 9\n")
    assert len(read_ensemble(tmp_path).runs) == 3
    file.write_text(text + "[time]\ntau = [0.1]\n")
    with pytest.raises(InputError, match="seed-0 and seed-1 in it are runs of cases that differ"):
        read_ensemble(tmp_path)


@pytest.mark.usefixtures("coarse")
def test_lengths_are_over_the_depth_of_the_body_and_areas_over_its_square(tmp_path) -> None:
    plane = sheets(drawn_ensemble(tmp_path / "plane", L=2.0))[1]
    solid = drawn_ensemble(tmp_path / "solid", BOX, L=2.0)
    length = solid.runs[0].steps[-1].measures.length_surface
    assert numbers(plane)[0][-1] == pytest.approx(length / 2)
    end = sheets(solid)[1]
    assert end.header[1:] == ("front", "area") and numbers(end)[0][-1] == pytest.approx(length / 4)
    drawn = draw_ensemble(solid)
    assert [p.name for p in drawn.pictures] == ["growth.png"]
    assert not any("measures.depths" in said for said in drawn.skipped)


@pytest.mark.usefixtures("coarse")
def test_a_case_with_units_has_its_numbers_in_them(tmp_path) -> None:
    """Not over L = 2 m; 16 cracks on 2.5 m, half of them stop at .14 m."""
    sizes = Magnitudes(extent=2.5, depth=1.0, last=1.0)
    written = {"length": Unit(name="mm", size=1e-3), "time": Unit(name="h", size=3600.0)}
    known = {"units": vars(choose_display_units(2, sizes, written)), "scaled": False, "L": 2.0}
    ensemble = drawn_ensemble(tmp_path, **known)
    network, end = sheets(ensemble)
    assert network.header[1:5] == ("p (mm)", "a0 (mm)", "t0 (h)", "tau0")
    assert column(network, "p (mm)").mean == pytest.approx(2500 / 16)
    assert column(network, "a1 (mm)").mean == pytest.approx(140)
    assert column(network, "t1 (h)").mean == pytest.approx(0.12**2 / 4 / 3600)
    assert column(network, "tau1").mean == pytest.approx(0.12), "ell/2 before it stops"
    assert column(end, "front (mm)").mean == pytest.approx(500)
    last = ensemble.runs[0].steps[-1].measures
    assert numbers(end)[0][-1] == pytest.approx(1000 * last.length_surface)
    assert not any(" over L" in note for sheet in (network, end) for note in sheet.notes)
    page = draw_ensemble(ensemble).page.read_text(encoding="utf-8")
    assert "<th>a<sub>1</sub> (mm)</th>" in page and "<th>t<sub>1</sub> (h)</th>" in page
    names, _ = results(tmp_path)
    assert names[:4] == ["p_mm", "a0_mm", "t0_h", "tau0"] and names[-1] == "length_mm"
    solid = drawn_ensemble(
        tmp_path / "solid", BOX, **known | {"units": vars(choose_display_units(3, sizes, written))}
    )
    end = sheets(solid)[1]
    assert end.columns[-1].unit.name == "mm²" and numbers(end)[0][-1] == pytest.approx(
        1e6 * solid.runs[0].steps[-1].measures.length_surface
    )


@pytest.mark.usefixtures("coarse")
def test_without_a_cooled_face_there_is_the_length_alone(tmp_path) -> None:
    whole = drawn_ensemble(tmp_path, face=None)
    for run in whole.runs.values():
        bare = [replace(step.measures, sections=(), tips=(), front=0.0) for step in run.steps]
        steps = zip(run.steps, bare, strict=True)
        rewritten(run, [replace(step, tau=None, measures=m) for step, m in steps])
    (end,) = sheets(read_ensemble(tmp_path))
    assert end.header == ("seed", "length") and column(end, "length").members == 3
    assert [p.name for p in draw_ensemble(read_ensemble(tmp_path)).pictures] == ["growth.png"]


@pytest.mark.usefixtures("coarse")
def test_a_member_that_is_not_finished_is_listed_and_counts_in_no_mean(tmp_path) -> None:
    run = drawn_ensemble(tmp_path).runs[1]
    bad = replace(run.steps[7], status=Status.NOT_CONVERGED, reason="out of sweeps")
    rewritten(run, [*run.steps[:7], bad])
    ensemble = read_ensemble(tmp_path)
    for sheet in sheets(ensemble):
        assert set(sheet.rows[1][1:]) == {None} and column(sheet, sheet.header[1]).members == 2
    told = {fact.name: fact for fact in facts(ensemble)}
    assert told["members"].text == "2 of 3 finished; seeds 0, 1, 2"
    assert told["seed 1"].alarm and "out of sweeps" in told["seed 1"].text
    assert len(draw_ensemble(ensemble).pictures) == 2
    rows = (tmp_path / "ensemble.csv").read_text(encoding="utf-8").splitlines()
    assert rows[2].startswith(
        '1,"not converged at step 7, 7 of 25 steps reached: out of sweeps",,,'
    )
    *others, last = sheets(ensemble)
    assert "in no mean: seed 1 (not converged at step 7, " in last.notes[-1]
    assert not any("in no mean" in note for sheet in others for note in sheet.notes)


def test_many_members_that_are_not_finished_are_grouped_and_counted(tmp_path) -> None:
    runs = drawn_ensemble(tmp_path).runs
    going = replace(runs[1], steps=runs[1].steps[:7])
    named = {f"seed {k}": going for k in range(7)} | {"seed 7": runs[0]}
    (sheet,) = with_left_out(sheets(read_ensemble(tmp_path))[:1], named)
    assert sheet.notes[-1] == (
        "Not finished, so in no mean: seed 0; seed 1; seed 2; seed 3; seed 4 and 2 more (7 of 25 "
        "steps; still going on, or stopped)."
    )
    several = {f"seed {k}": replace(going, steps=going.steps[:k]) for k in range(1, 8)}
    (sheet,) = with_left_out(sheets(read_ensemble(tmp_path))[:1], several)
    assert sheet.notes[-1].endswith(
        "seed 5 (5 of 25 steps; still going on, or stopped) and 2 more."
    )


def test_with_one_finished_member_there_are_numbers_and_no_picture(tmp_path) -> None:
    for seed, run in drawn_ensemble(tmp_path).runs.items():
        rewritten(run, list(run.steps[: 25 if seed == 2 else seed]))
    drawn = draw_ensemble(read_ensemble(tmp_path))
    assert drawn.pictures == () and "two finished members" in drawn.skipped[0]
    end = sheets(read_ensemble(tmp_path))[1]
    assert column(end, "cracks at 0.4") == Average(mean=6, error=None, members=1)


def test_what_is_an_ensemble_and_what_is_none(tmp_path) -> None:
    ensemble = drawn_ensemble(tmp_path / "e")
    (tmp_path / "e" / "seed-x").mkdir()
    (tmp_path / "e" / "seed-07").mkdir()
    assert is_ensemble(tmp_path / "e") and list(read_ensemble(tmp_path / "e").runs) == [0, 1, 2]
    assert not is_ensemble(ensemble.runs[0].path) and not is_ensemble(tmp_path)
    assert not is_ensemble(tmp_path / "nowhere")
    text = (ensemble.runs[2].path / CASE).read_text()
    write_aside(ensemble.runs[2].path / CASE, f'authors = ["Ada"]\n{text}')
    assert len(read_ensemble(tmp_path / "e").runs) == 3, "authors make no other case"
    write_aside(ensemble.runs[2].path / CASE, f"{text}[damage]\nell = 0.5\n")
    said = sentence_of(lambda: read_ensemble(tmp_path / "e"))
    check_sentence(said, "seed-0 and seed-2", "move one of them")


# ---- real ones ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def real(tmp_path_factory) -> Path:
    """A folder with small.toml, and the ensemble `e` of its seeds 3, 4 and 5."""
    folder = tmp_path_factory.mktemp("ensemble")
    (folder / "small.toml").write_text(SMALL)
    done = staffa(folder, "ensemble", "small.toml", "--seeds", "3", "--out", "e")
    assert done.returncode == 0, done.stderr
    assert "seed 4 (member 2 of 3), A small slab" in done.stdout
    assert "3 of 3 finished; seeds 3, 4, 5" in done.stdout and "e/report.html" in done.stdout
    return folder


def results(folder: Path) -> tuple[list[str], dict[str, list[float | None]]]:
    """Names of the columns, and the row of each seed and of mean, error and members."""
    with (folder / "ensemble.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    return header[2:], {row[0]: [float(v) if v else None for v in row[2:]] for row in rows}


def comparable(row: list[float | None]) -> list[float]:
    """A row whose empty cells are equal to one another and to no number."""
    return [-1.0 if value is None else value for value in row]


def expected(path: Path) -> list[float | None]:
    """The row of a member that follows from its steps."""
    run = open_run(path)
    L, last = 0.8, run.steps[-1].measures
    reach = run.manifest.tip_reach
    assert reach is not None and reach > 0.75 * 0.06
    found = arrests(run.steps, axis=face_axis("bottom", 2), ell=0.06, sharp=run.manifest.sharp)
    begin = found.nucleation
    row = [begin.spacing / L, begin.depth / L, begin.tau]
    row += [number for g in found.generations for number in (g.depth / L, g.tau)]
    row += [None] * (2 - 2 * len(found.generations))
    front = last.front + reach if last.front else 0.0
    return [*row, *(s.cracks for s in last.sections), front / L, last.length_surface / L]


@pytest.mark.slow
def test_the_results_are_those_of_the_members(real: Path) -> None:
    names, rows = results(real / "e")
    assert names == [
        *("p", "a0", "tau0", "a1", "tau1", "cracks at 0.1", "cracks at 0.2", "front", "length")
    ]
    assert list(rows) == ["3", "4", "5", "mean", "error", "members"]
    members = [expected(real / "e" / f"seed-{seed}") for seed in (3, 4, 5)]
    for row, should in zip(rows.values(), members, strict=False):
        assert comparable(row) == pytest.approx(comparable(should), rel=1e-5)  # six digits
    assert len({tuple(row) for row in members}) == 3, "the seeds are different rocks"
    for number, values in enumerate(zip(*members, strict=True)):
        known = [value for value in values if value is not None]
        assert rows["members"][number] == len(known) > 0
        assert rows["mean"][number] == pytest.approx(mean(known), rel=1e-5)
        if len(known) == 1:
            assert rows["error"][number] is None
        else:
            error = stdev(known) / sqrt(len(known))
            assert rows["error"][number] == pytest.approx(error, rel=1e-5), names[number]


@pytest.mark.slow
def test_a_member_is_an_ordinary_run(real: Path, tmp_path: Path) -> None:
    """The same as `staffa run` with that seed; and what `staffa show` is asked for it shows."""
    setting = ("--set", "toughness.seed=4")
    done = staffa(real, "run", "small.toml", *setting, "--out", str(tmp_path / "run"), "--quiet")
    assert done.returncode == 0, done.stderr
    one, other = open_run(tmp_path / "run"), open_run(real / "e" / "seed-4")
    assert one.case == other.case
    assert [s.energies for s in one.steps] == [s.energies for s in other.steps]
    assert "finished, 3 of 3 steps" in staffa(real, "show", "e/seed-4").stdout
    shown = staffa(real, "show", "e").stdout
    assert "3 of 3 finished; seeds 3, 4, 5" in shown and "│ mean" in shown


def test_a_member_solved_in_another_way_is_of_the_ensemble_and_one_of_other_rock_is_not(
    tmp_path: Path,
) -> None:
    case = parse_case(SMALL)
    drawn_ensemble(tmp_path)
    about = "license='CC-BY-4.0'"  # tells of the case, and decides nothing
    for seed, setting in enumerate(("solver.sweeps=9", about, "damage.ell=0.11")):
        text = to_toml(parse_case(SMALL, [f"toughness.seed={seed}", setting]))
        (tmp_path / f"seed-{seed}" / CASE).write_text(text)
    aside = (tmp_path / "seed-2" / CASE).rename(tmp_path / "seed-2" / "aside")
    assert set(started_members(case, range(2), tmp_path)) == {0, 1}
    aside.rename(tmp_path / "seed-2" / CASE)
    with pytest.raises(InputError, match="holds a run of another case, seed-2"):
        started_members(case, range(3), tmp_path)


def test_a_member_that_another_process_is_beginning_has_started(tmp_path: Path) -> None:
    """Its folder has its case and no manifest yet; a job of another member does not look at it."""
    case, place = parse_case(SMALL), tmp_path / "seed-1"
    place.mkdir()
    lock = Lock(place)
    lock.take()
    assert Lock(place).is_held() and not Lock(tmp_path).is_held()
    for name in (STEPS, CASE):
        (place / name).write_text("")
        assert started_members(case, range(3), tmp_path) == {1: False}
        assert [one.finished for one in ensemble_members(case, range(3), tmp_path, only=1)] == [
            None
        ] * 3
    lock.release()
    assert started_members(case, range(3), tmp_path, only=2) == {}
    with pytest.raises(InputError, match="holds a run"):
        started_members(case, range(3), tmp_path)
    with pytest.raises(InputError, match="--member 4: this command has 3 members"):
        ensemble_members(case, range(3), tmp_path, only=4)


@pytest.mark.slow
def test_finished_members_are_taken_and_not_run_again(real: Path, tmp_path: Path) -> None:
    shutil.copytree(real / "e", tmp_path / "e")
    before = files_in(tmp_path / "e" / "seed-4")
    done = staffa(real, "ensemble", "small.toml", "--seeds", "4", "--out", str(tmp_path / "e"))
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("is finished already") == 3 and "step   2" in done.stdout
    assert files_in(tmp_path / "e" / "seed-4") == before
    _, rows = results(tmp_path / "e")
    assert list(rows)[:4] == ["3", "4", "5", "6"] and rows["members"][0] == 4
    assert [rows[s] for s in "345"] == [results(real / "e")[1][s] for s in "345"]


REFUSED = [
    (
        lambda folder: (folder / "seed-4" / "manifest.json").unlink(),
        (),
        "seed-4 holds a run that was cut before it began",
        "remove it",
    ),
    (lambda folder: None, ("--set", "time.tau=[0.1]"), "another case, seed-3", "another folder"),
    (
        lambda folder: (folder / "seed-6").write_text(""),
        ("--first", "6"),
        "seed-6 is a file",
        "new or empty",
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "arguments", "names", "way_out"),
    REFUSED,
    ids=lambda v: getattr(v, "__name__", str(v))[:30],
)
def test_what_cannot_be_a_member_is_refused_and_nothing_written(
    real: Path, tmp_path: Path, change, arguments, names, way_out
) -> None:
    shutil.copytree(real / "e", tmp_path / "e")
    change(tmp_path / "e")
    before = files_in(tmp_path)
    asked = ("small.toml", "--seeds", "4", "--out", str(tmp_path / "e"), *arguments)
    done = staffa(real, "ensemble", *asked)
    assert done.returncode == 2 and done.stdout == "", done.stdout + done.stderr
    assert names in done.stderr and way_out in done.stderr and done.stderr.count("\n") == 1
    assert files_in(tmp_path) == before


@pytest.mark.slow
def test_a_member_that_fails_loses_none_of_the_others(
    real: Path, tmp_path: Path, monkeypatch, capsys
) -> None:
    """The second of three runs out of sweeps."""
    from staffa.case.reading.read import read_case
    from staffa.cli.members import Way, run_members_and_follow
    from staffa.records.step import Stop
    from staffa.runs import run as experiment

    calls, march = [], experiment.march_session

    def tiring(session, observers, restart):
        calls.append(session)
        if len(calls) == 2:
            solvers = replace(session.problem.solvers, stop=Stop(sweeps=1))
            session.problem = replace(session.problem, solvers=solvers)
        yield from march(session, observers, restart)

    monkeypatch.setattr(experiment, "march_session", tiring)
    with pytest.raises(SolveError) as caught:
        run_members_and_follow(
            lambda: read_case(real / "small.toml"),
            tmp_path / "e",
            count=3,
            first=None,
            way=Way(quiet=True),
        )
    said = str(caught.value)
    assert "1 of 3 members failed (seed 4)" in said and "try shorter time steps" in said
    assert caught.value.exit_code == 1 and capsys.readouterr().out == ""
    names, rows = results(tmp_path / "e")
    assert set(rows["4"]) == {None} and rows["members"] == [2] * len(names)
    whole = results(real / "e")[1]
    for seed in "35":  # a1 and tau1 are seed 4's alone
        assert rows[seed] == [v for v in whole[seed] if v is not None]
    assert "not converged at step 0" in (tmp_path / "e" / "ensemble.csv").read_text()


def test_a_seed_whose_rock_cannot_be_stops_none_of_the_others(tmp_path: Path, monkeypatch) -> None:
    case = parse_case(SMALL, ["material.nu={mean=0.25,variation=0.22,length=0.06}"])
    ran = []

    def run_member(case, place, **more) -> None:
        problem(case, comm=MPI.COMM_SELF)
        ran.append(case.toughness.seed)

    monkeypatch.setattr("staffa.runs.member_runs.run", run_member)
    found = run_members(ensemble_members(case, range(5, 8), tmp_path), comm=MPI.COMM_WORLD)
    failures = {one.case.toughness.seed: said for one, said in found.items()}
    assert failures and ran and sorted([*failures, *ran]) == [5, 6, 7]
    assert all("in the middle of every cell" in said for said in failures.values())
    only = next(iter(failures))
    with pytest.raises(InputError, match="in the middle of every cell"):
        alone = ensemble_members(case, range(only, only + 1), tmp_path)
        run_members(alone, comm=MPI.COMM_WORLD)


@pytest.mark.slow
def test_where_all_fail_each_is_listed_and_the_exit_code_tells(real: Path, tmp_path: Path) -> None:
    asked = ("small.toml", "--seeds", "2", "--out", str(tmp_path / "e"))
    done = staffa(real, "ensemble", *asked, "--set", "solver.sweeps=1")
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert "2 of 2 members failed (seed 3, 4), seed 3 because: step 0" in done.stderr
    lines = (tmp_path / "e" / "ensemble.csv").read_text().splitlines()
    assert lines[0] == "seed,status" and [line[:17] for line in lines[1:3]] == [
        '3,"not converged ',
        '4,"not converged ',
    ]
    assert "0 of 2 finished" in done.stdout and "two finished members" in done.stdout


def test_a_member_has_other_seeds_in_every_random_property() -> None:
    """Random properties of regions too; the others stay."""
    random = "{mean=1.0, variation=0.1, length=0.1, seed=7}"
    settings = [
        f"material.E={random}",
        f"regions.top={{lower=[0.0,0.5], upper=[1.0,0.8], Gc={random}}}",
        "toughness.seed=3",
    ]
    case = parse_case(SMALL, [*settings, "toughness.amplitude=0"])
    other = member(case, 5)
    assert (other.toughness.seed, other.material.E.seed, other.regions["top"].Gc.seed) == (5, 9, 9)
    assert other.material.nu == case.material.nu and member(case, 3) == case
    assert seeds_from(case, count=2) == range(3, 5)


RANDOM_ROCK = """[domain]
size = [0.6, 0.4]
h = 0.1
[material]
Gc = { mean = 1.0, variation = 0.2, length = 0.2, seed = 1 }
[regions.cap]
lower = [0.0, 0.2]
upper = [0.6, 0.4]
E = { mean = 2.0, variation = 0.1, length = 0.2, seed = 7 }
[damage]
ell = 0.3
[temperature]
severity = 3.0
[time]
tau = [0.2]
"""


@pytest.mark.long
def test_random_properties_make_an_ensemble_too(tmp_path: Path) -> None:
    """Their seeds stand within the line of a property, and go with that of [toughness]."""
    (tmp_path / "my.toml").write_text(RANDOM_ROCK)
    done = staffa(tmp_path, "ensemble", "my.toml", "--seeds", "2", "--out", str(tmp_path / "e"))
    assert done.returncode == 0, done.stderr
    assert "2 of 2 finished" in done.stdout
    one, other = read_ensemble(tmp_path / "e").runs.values()
    assert "seed = 8 }" in other.case and one.steps[0].energies != other.steps[0].energies
    assert "2 of 2 finished" in staffa(tmp_path, "show", "e").stdout

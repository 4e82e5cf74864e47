"""Studies that are written by hand: their numbers, tables, pictures and page."""

import csv
import fcntl
from collections.abc import Sequence
from dataclasses import replace
from errno import ENOSYS
from math import sqrt
from pathlib import Path

import pytest

from report.test_report import assert_shows_something, drawn_run, rewritten
from staffa.case.reading.study_points import study_points
from staffa.display_units import Magnitudes, choose_display_units
from staffa.errors import InputError, StaffaError
from staffa.io.own_files import write_aside
from staffa.io.run_directory import CASE
from staffa.io.study_directory import (
    PLAN,
    Study,
    StudyPlan,
    is_of_study,
    is_study,
    point_identity,
    point_path,
    read_plan,
    read_study,
    write_plan,
)
from staffa.plot.study_production import PointProduction
from staffa.records.status import Status
from staffa.report.drawing import draw_study
from staffa.report.provenance_tables import ensemble_again, study_again
from staffa.results import study_table as study_numbers
from staffa.results.study_curves import abscissa, productions, responses
from staffa.results.study_table import study_facts, study_means, study_sheets, study_table
from support.circulating import DAY, HOT, shadowed_run

METERS = vars(choose_display_units(2, Magnitudes(extent=2.5, depth=1.0, last=1.0)))


def planned(folder: Path, *over: str, samples: int | None = None) -> StudyPlan:
    parameters, points = study_points(over, samples=samples)
    plan = StudyPlan(version="0", title="drawn <here>", parameters=parameters, points=points)
    write_plan(folder, plan)
    return plan


def drawn_study(folder: Path, *over: str, seeds: int = 2, **more: int) -> Study:
    """A point more is a length that is larger by a tenth, a seed more by a hundredth."""
    for point in planned(folder, *over, **more).points:
        for seed in range(seeds):
            place = point_path(folder, point.number) / f"seed-{seed}"
            run = drawn_run(place, n=6, units=METERS, scaled=False, L=2.0)
            write_aside(place / CASE, f'title = "drawn"\n[toughness]\nseed = {seed}\n')
            factor = 1 + 0.1 * (point.number - 1) + 0.01 * seed
            last = run.steps[-1]
            assert last.measures is not None
            m = replace(last.measures, length_surface=factor * last.measures.length_surface)
            rewritten(run, [*run.steps[:-1], replace(last, measures=m)])
    return read_study(folder)


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(text.splitlines()))


def test_each_run_has_a_row_with_its_parameters_in_their_units(tmp_path: Path) -> None:
    study = drawn_study(tmp_path, "material.Gc=40:60:2 J/m^2", "damage.law=AT1,AT2")
    found = rows(study_table(study).csv())
    assert [(row["point"], row["seed"]) for row in found][:3] == [
        ("1", "0"),
        ("1", "1"),
        ("2", "0"),
    ]
    assert [row["material.Gc_J_per_m2"] for row in found] == ["40.0"] * 4 + ["60.0"] * 4
    assert [row["damage.law"] for row in found] == ["AT1", "AT1", "AT2", "AT2"] * 2
    assert {row["status"] for row in found} == {"finished, 25 of 25 steps"}
    first = study.first.steps[-1]
    assert float(found[5]["length_m"]) == pytest.approx(1.21 * first.measures.length_surface)
    assert float(found[0]["p_m"]) == pytest.approx(2.5 / 16), "16 cracks on a width of 2.5"
    assert float(found[0]["a1_m"]) == pytest.approx(0.14)
    unit = study.first.manifest.shown.energy
    total = float(found[0][unit.column("total_energy")])
    assert total == pytest.approx(unit.of(first.energies.total))


def test_means_and_errors_of_a_point_are_those_of_its_seeds(tmp_path: Path) -> None:
    """Two seeds whose lengths differ by d have an error of d/2."""
    study = drawn_study(tmp_path, "material.Gc=40:60:3 J/m^2")
    length = study.first.steps[-1].measures.length_surface
    found = rows(study_means(study).csv())
    assert [row["members"] for row in found] == ["2", "2", "2"]
    assert [float(row["length_m"]) for row in found] == pytest.approx(
        [f * length for f in (1.005, 1.105, 1.205)]
    )
    assert [float(row["length_error_m"]) for row in found] == pytest.approx([0.005 * length] * 3)
    (sheet,) = [sheet for sheet in study_sheets(study) if sheet.title == "The last step"]
    assert sheet.header[:3] == ("point", "Gc (J/m²)", "runs")
    shown = sheet.lines[0][sheet.header.index("length (m)")]
    assert shown == f"{1.005 * length:.4g} ± {0.005 * length:.2g}"


def test_a_run_that_is_not_finished_is_listed_and_counts_in_no_mean(tmp_path: Path) -> None:
    study = drawn_study(tmp_path, "material.Gc=40:60:2 J/m^2")
    run = study.ensembles[2].runs[1]
    bad = replace(run.steps[7], status=Status.NOT_CONVERGED, reason="out of sweeps")
    rewritten(run, [*run.steps[:7], bad])
    study = read_study(tmp_path)
    found = rows(study_table(study).csv())
    assert found[3]["length_m"] == "" and "out of sweeps" in found[3]["status"]
    means = rows(study_means(study).csv())
    assert means[1]["members"] == "1" and means[1]["length_error_m"] == ""
    told = {fact.name: fact for fact in study_facts(study)}
    assert told["point 2, seed 1"].alarm and "3 of 4 runs finished" in told["points"].text
    notes = [note for sheet in study_sheets(study) for note in sheet.notes if "no mean" in note]
    assert len(notes) == 1 and notes[0].startswith(
        "Not finished, so in no mean: point 2, seed 1 (not converged at step 7, "
    )


def test_curves_are_those_of_the_other_parameters_with_the_same_values(tmp_path: Path) -> None:
    study = drawn_study(tmp_path, "a.b=1:3:3 mm", "a.c=5,6", seeds=1)
    over = abscissa(study, 0)
    assert over.label == "a.b (mm)" and over.others == "a.c"
    assert over.curves == [("5", [0, 2, 4]), ("6", [1, 3, 5])]
    assert list(over.places) == [1, 1, 2, 2, 3, 3]
    (length,) = [one for one in responses(study) if one.label.startswith("length")]
    first = length.values[0][0]
    assert [values[0] / first for values in length.values] == pytest.approx(
        [1.0, 1.1, 1.2, 1.3, 1.4, 1.5]
    )


def test_points_of_a_hypercube_and_texts_have_places_of_their_own(tmp_path: Path) -> None:
    over = ("a.b=1:3 mm", "a.c=5:6")
    study = drawn_study(tmp_path / "cube", *over, seeds=1, samples=4)
    assert abscissa(study, 0).curves == [("", [0, 1, 2, 3])]
    study = drawn_study(tmp_path / "texts", "damage.law=AT2,AT1", seeds=1)
    axis = abscissa(study, 0)
    assert list(axis.places) == [0, 1] and axis.texts == ["AT2", "AT1"] and axis.is_text


@pytest.mark.parametrize(
    ("over", "more"),
    [
        (("material.Gc=40:60:3 J/m^2",), {}),
        (("damage.law=AT1,AT2", "a.c=5,6"), {"seeds": 1}),
        (("a.b=1:3 mm", "a.c=5:6"), {"seeds": 1, "samples": 4}),
    ],
)
def test_pictures_and_page_show_something(tmp_path: Path, over: Sequence[str], more) -> None:
    study = drawn_study(tmp_path, *over, **more)
    drawn = draw_study(study)
    names = [f"response-{k + 1}" for k in range(len(over))]
    assert [path.stem for path in drawn.pictures] == names and not drawn.skipped
    for picture in drawn.pictures:
        assert_shows_something(picture)
    page = drawn.page.read_text(encoding="utf-8")
    assert "<title>Study: drawn &lt;here&gt;</title>" in page and "Nucleation and arrests" in page
    assert [path.name for path in drawn.tables] == ["study.csv", "study_means.csv"]
    assert all(is_of_study(path) for path in tmp_path.iterdir())


def test_each_run_is_read_once_for_tables_pictures_and_page(tmp_path: Path, monkeypatch) -> None:
    study, read = drawn_study(tmp_path, "a.b=1,2", seeds=2), []
    of = study_numbers.GROUPS["The last step"]
    monkeypatch.setitem(
        study_numbers.GROUPS, "The last step", lambda run: read.append(run) or of(run)
    )
    draw_study(study)
    assert sorted(run.path for run in read) == sorted(run.path for run in study.finished)
    again = read_study(tmp_path)
    draw_study(again)
    assert len(read) == 8, "a study that is read again has its own numbers"


def test_one_point_has_numbers_and_no_picture(tmp_path: Path) -> None:
    study = drawn_study(tmp_path, "material.Gc=40:60:2 J/m^2")
    (tmp_path / "point-2").rename(tmp_path.parent / "aside")
    study = read_study(tmp_path)
    drawn = draw_study(study)
    assert drawn.pictures == () and len(rows(study_table(study).csv())) == 2


FALLS = {1: [0.0, 1.0, 4.0, 8.0], 2: [0.0, 2.0, 6.0, 12.0]}


def water_study(folder: Path) -> Study:
    """Two rates; the production temperature (K) falls by FALLS, of a second seed by 1 K more."""
    for point in planned(folder, "reservoir.wells.in.rate=2:4:2 kg/s").points:
        for seed in range(2):
            place = point_path(folder, point.number) / f"seed-{seed}"
            falls = [fall + seed for fall in FALLS[point.number]]
            shadowed_run(place, falls, [0.0, 2.0, 8.0, 16.0], every=10 * DAY)
            write_aside(place / CASE, f'title = "drawn"\n[toughness]\nseed = {seed}\n')
    return read_study(folder)


def test_production_of_each_point_is_the_mean_of_its_seeds(tmp_path: Path) -> None:
    study = water_study(tmp_path)
    one, other = productions(study)
    assert isinstance(one, PointProduction) and (one.label, other.label) == ("2 kg/s", "4 kg/s")
    assert HOT - one.spreads["T"].mean == pytest.approx([0.5, 1.5, 4.5, 8.5])
    assert HOT - other.spreads["T"].mean == pytest.approx([0.5, 2.5, 6.5, 12.5])
    assert one.spreads["T"].error == pytest.approx([0.5] * 4)
    found = rows(study_means(study).csv())
    assert [float(row["T_degC"]) for row in found] == pytest.approx([191.5, 187.5])
    assert [float(row["T_error_degC"]) for row in found] == pytest.approx([0.5, 0.5])
    drawn = draw_study(study)
    assert [path.stem for path in drawn.pictures] == ["response-1", "study-production"]
    for picture in drawn.pictures:
        assert_shows_something(picture)


def test_many_points_with_water_have_a_scale_of_colors(tmp_path: Path) -> None:
    for point in planned(tmp_path, "reservoir.wells.in.rate=1:20:20 kg/s").points:
        place = point_path(tmp_path, point.number) / "seed-0"
        shadowed_run(place, FALLS[1], FALLS[2], every=10 * DAY)
        write_aside(place / CASE, 'title = "drawn"\n[toughness]\nseed = 0\n')
    drawn = draw_study(read_study(tmp_path))
    (picture,) = [path for path in drawn.pictures if path.stem == "study-production"]
    assert_shows_something(picture)


def test_a_plan_loses_no_point_that_another_command_added(tmp_path: Path) -> None:
    """A job has read two points, another command has added a third: the job writes nothing."""
    parameters, points = study_points(["a.b=1,2,3"])
    whole = StudyPlan(version="0", title="", parameters=parameters, points=points)
    early = replace(whole, points=points[:2])
    assert write_plan(tmp_path, early) is None and write_plan(tmp_path, whole) is None
    assert write_plan(tmp_path, early) is None and read_plan(tmp_path) == whole
    other = replace(whole, points=(*points[:2], replace(points[2], texts=("4",))))
    with pytest.raises(InputError, match=r"has added points to .* meanwhile; give this one again"):
        write_plan(tmp_path, other)
    assert read_plan(tmp_path) == whole


def test_a_plan_without_a_lock_is_told_of(tmp_path: Path, monkeypatch) -> None:
    def refused(file: int, kind: int) -> None:
        raise OSError(ENOSYS, "no locks")

    monkeypatch.setattr(fcntl, "flock", refused)
    parameters, points = study_points(["a.b=1,2"])
    plan = StudyPlan(version="0", title="", parameters=parameters, points=points)
    assert "has no lock: add points with one command at a time" in str(write_plan(tmp_path, plan))
    assert write_plan(tmp_path, plan) is None, "which has these points already"


def test_a_point_whose_runs_are_of_another_case_is_told_of(tmp_path: Path) -> None:
    study = drawn_study(tmp_path, "a.b=1,2", seeds=1)
    own, other = (point_identity(f"title = 't'\n[toughness]\nseed = 5\n{m}") for m in ("", "a=1"))
    points = [
        replace(point, case=case)
        for point, case in zip(study.plan.points, (own, other), strict=True)
    ]
    plan = replace(study.plan, version=study.first.manifest.version, points=tuple(points))
    found = replace(study, plan=plan)
    assert [point.number for point in found.of_another_case] == [2]
    told = {fact.name: fact for fact in study_facts(found)}
    assert told["point 2"].alarm and "of another case" in told["point 2"].text
    assert not replace(study, plan=replace(plan, version="another")).of_another_case


def test_the_command_that_repeats_is_true_of_seeds_with_gaps(tmp_path: Path) -> None:
    study = drawn_study(tmp_path / "s", "a.b=1,2", seeds=2)
    ((_, command),) = study_again(study)
    assert command.startswith("mpiexec -n 2 staffa study "), "as many ranks as the runs had"
    assert "--over 'a.b=[1, 2]' --seeds 2 --first 0 --out" in command
    ensemble = study.ensembles[1]
    ((_, command),) = ensemble_again(ensemble)
    assert "--seeds 2 --first 0 --out" in command
    gap = replace(ensemble, runs={0: ensemble.runs[0], 2: ensemble.runs[1]})
    for said in (ensemble_again(gap), study_again(replace(study, ensembles={1: gap}))):
        assert said[0][0].startswith("Its seeds, 0, 2, are not one range") and not said[0][1]
    alone = replace(ensemble, runs={1: ensemble.runs[1]})
    assert ensemble_again(alone)[0][1].startswith("mpiexec -n 2 staffa run seed-1/case.toml --out")
    one, other = study.plan.points
    pairs = (replace(one, texts=("1", "1")), replace(other, texts=("2", "2")))
    union = replace(study.plan, parameters=study.plan.parameters * 2, points=pairs)
    assert study_again(replace(study, plan=union)) == (
        ("Its points are no grid: study.json has them.", ""),
    )


def test_what_is_no_study_is_said(tmp_path: Path) -> None:
    planned(tmp_path, "a.b=1,2")
    assert is_study(tmp_path) and not is_study(tmp_path.parent)
    with pytest.raises(InputError, match="no run of the study"):
        read_study(tmp_path)
    (tmp_path / PLAN).write_text('{"format": 2, "version": "9.0"}')
    with pytest.raises(InputError, match=r"has format 2, this staffa reads 1.*9\.0"):
        read_study(tmp_path)
    (tmp_path / PLAN).write_text('{"format": 1')
    with pytest.raises(StaffaError, match="is damaged"):
        read_study(tmp_path)


def test_the_error_of_three_seeds_is_that_by_hand(tmp_path: Path) -> None:
    study = drawn_study(tmp_path, "a.b=1,2", seeds=3)
    length = study.first.steps[-1].measures.length_surface
    (first, _) = rows(study_means(study).csv())
    assert float(first["length_error_m"]) == pytest.approx(0.01 * length / sqrt(3))


def test_dollars_in_names_and_values_are_no_formula(tmp_path: Path) -> None:
    """Matplotlib would read "$a^$" as one, with an error."""
    study = drawn_study(tmp_path, '"a.$b^$"=["$a^$ x", "b"]', "c.d=$e^$,$f^$", seeds=2)
    drawn = draw_study(study)
    assert [path.stem for path in drawn.pictures] == ["response-1", "response-2"]
    over = abscissa(study, 0)
    assert over.texts == ["$a^$ x", "b"] and [name for name, _ in over.curves] == ["$e^$", "$f^$"]

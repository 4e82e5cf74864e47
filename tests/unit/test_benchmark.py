"""benchmarks/: the scorer, its tables, and the scores of the committed submissions."""

import csv
import json
import subprocess
import sys
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from benchmarks import make_tables, score, update_scores
from staffa import parse_case
from staffa.setup.toughness_and_cracks import toughness_factor
from verification.common.sharp import DATA
from verification.energies.run import BODIES

FOLDER = Path(score.__file__).parent
SUBMISSIONS = sorted(update_scores.SUBMISSIONS.iterdir())


def perfect(folder: Path, *, times: float = 1.0) -> Path:
    """Write the references, times a factor, as a submission."""
    folder.mkdir(exist_ok=True)
    for file in score.REFERENCE.glob("*.csv"):
        with file.open() as opened, (folder / file.name).open("w") as to:
            rows = csv.writer(to)
            rows.writerow(score.COLUMNS)
            for row in csv.DictReader(opened):
                rows.writerow((row["quantity"], row["at"], times * float(row["value"])))
    return folder


def verdicts(folder: Path) -> set[str]:
    return {figure.verdict for figure in score.score(folder)}


def test_the_references_themselves_are_within(tmp_path: Path) -> None:
    assert verdicts(perfect(tmp_path)) == {score.WITHIN}


def test_wrong_numbers_are_outside_and_lower_energies_are_not(tmp_path: Path) -> None:
    assert verdicts(perfect(tmp_path, times=1.2)) == {score.OUTSIDE}
    low = {f.case for f in score.score(perfect(tmp_path, times=0.8)) if f.verdict == score.WITHIN}
    assert low == {"energies"}, "the reference of an energy is an upper bound"


def test_an_energy_far_below_the_bound_is_within_and_gets_a_note(tmp_path, capsys) -> None:
    for times, noted in ((0.89, True), (0.91, False)):
        folder = perfect(tmp_path / f"{times}", times=times)
        told = folder / "scores.json"
        assert score.main([str(folder), "--json", str(told)]) == 0
        assert ("below our bound: please tell us" in capsys.readouterr().out) is noted
        rows = json.loads(told.read_text())["figures"]
        energies = [row for row in rows if row["case"] == "energies"]
        assert {row["verdict"] for row in energies} == {score.WITHIN}
        assert {row["note"] for row in energies} == {score.NOTE if noted else ""}
        assert {row["note"] for row in rows if row["case"] != "energies"} == {""}


@pytest.mark.parametrize("value", ["-5", "0", "-0.0", "-1e-300"])
def test_an_energy_that_cannot_be_is_refused(tmp_path, capsys, value) -> None:
    text = f"quantity,at,value\ntotal energy,0.04,0.2\ntotal energy,0.06,{value}\n"
    (tmp_path / "energies.csv").write_text(text)
    assert score.main([str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert f'energies.csv, line 3: value = {value} of "total energy" cannot be' in said


def test_what_is_not_told_is_missing(tmp_path: Path) -> None:
    (perfect(tmp_path) / "pair.csv").unlink()
    cases = score.by_case(score.score(tmp_path))
    assert cases.pop("pair")["verdict"] == score.MISSING
    assert {counts["verdict"] for counts in cases.values()} == {score.WITHIN}


def test_an_arrest_that_never_came_is_outside(tmp_path: Path) -> None:
    text = "quantity,at,value\narrest length,,inf\narrest tau,,inf\n"
    (tmp_path / "doubling.csv").write_text(text)
    found = [figure for figure in score.score(tmp_path) if figure.case == "doubling"]
    assert [figure.verdict for figure in found] == [score.OUTSIDE] * 2
    rows = json.loads(score.record(tmp_path, found))["figures"]
    assert [row["value"] for row in rows] == ["inf"] * 2


def test_a_curve_is_linear_between_its_rows_and_missing_beyond_them() -> None:
    curve: dict[float | None, float] = {0.3: 3.0, 0.1: 1.0}
    assert score.value_at(curve, 0.15) == pytest.approx(1.5)
    assert score.value_at(curve, 0.3 + 1e-12) == 3.0
    assert score.value_at(curve, 0.31) is None


def test_no_line_is_drawn_across_more_than_two_steps_of_the_reference(tmp_path: Path) -> None:
    """Two rows, at both ends of the curve, are two values and not the whole of it."""

    def known(*places: float) -> list[float | None]:
        rows = "".join(f'"length, fixed",{at},0.1\n' for at in places)
        (tmp_path / "array.csv").write_text(f"quantity,at,value\n{rows}")
        return [figure.at for figure in score.score(tmp_path) if figure.value is not None]

    assert known(0.07, 0.10) == [0.07, 0.10]
    assert known(0.07, 0.09, 0.10) == [0.07, 0.08, 0.09, 0.10]
    assert known(0.0651, 0.0849) == [0.07, 0.08]
    assert known(0.0649, 0.0851) == []


BAD = {
    "": "begins with",
    "quantity,value\n": "its first line must be",
    "quantity,at,value\nlength,0.1,0.2\n": "is no quantity of this case",
    'quantity,at,value\n"length, fixed",,0.2\n': "say in column at",
    'quantity,at,value\n"length, fixed",0.1,long\n': "is no number",
    'quantity,at,value\n"length, fixed",0.1,nan\n': "leave the row out",
    'quantity,at,value\n"length, fixed",0.1,inf\n': "leave the row out",
    'quantity,at,value\n"length, fixed",inf,0.1\n': "leave the row out",
    'quantity,at,value\n"length, fixed",0.1\n': "write three",
    "quantity,at,value\nlength, fixed,0.1,0.2\n": "comma in quotes",
    f'quantity,at,value\n"{"x" * 200_000}",0.1,0.2\n': "cannot be read",
    'quantity,at,value\n"length, fixed",0.1,1\n"length, fixed",0.10,1\n': "line 3: a second value",
    'quantity,at,value\n"length, fixed",0.1,1\n"length, fixed",0.1000000001,2\n': "are one place",
    'quantity,at,value\n"length, fixed",0.1,0_1.3\n': "is no number",
    'quantity,at,value\n"length, fixed",0_0.1,1.3\n': "is no number",
}


@pytest.mark.parametrize(("text", "said"), BAD.items())
def test_a_malformed_file_is_refused_in_a_sentence(tmp_path, capsys, text, said) -> None:
    (tmp_path / "array.csv").write_text(text)
    assert score.main([str(tmp_path)]) == 2
    captured = capsys.readouterr()
    assert said in captured.err and "array.csv" in captured.err and captured.out == ""
    assert len(captured.err.splitlines()) == 1


@pytest.mark.parametrize(
    ("file", "content", "said"),
    [
        ("arrays.csv", b"quantity,at,value\n", "named after no case; the cases are array, bar"),
        ("bar.csv", b"\xff\xfe\x00", "write it as UTF-8"),
        ("bar.csv", b"quantity,at,value\nstrength,0.1,19\n", "leave column at empty"),
        ("notes.txt", b"", "holds no CSV file"),
    ],
)
def test_a_file_of_no_case_is_refused(tmp_path, capsys, file, content, said) -> None:
    (tmp_path / file).write_bytes(content)
    assert score.main([str(tmp_path)]) == 2
    assert said in capsys.readouterr().err


def test_a_folder_that_is_not_there_is_refused(tmp_path, capsys) -> None:
    assert score.main([str(tmp_path / "nowhere")]) == 2
    assert "is no folder" in capsys.readouterr().err


def test_the_script_needs_nothing_but_python(tmp_path: Path) -> None:
    """Isolated, without site packages and without this repository on its path."""
    script = [sys.executable, "-I", "-S", str(FOLDER / "score.py"), str(perfect(tmp_path))]
    told = tmp_path / "scores.json"
    done = subprocess.run([*script, "--json", str(told)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "8 of 8 within" in done.stdout
    assert {case["verdict"] for case in json.loads(told.read_text())["cases"].values()} == {
        "within"
    }


@pytest.mark.parametrize("case", make_tables.TABLES)
def test_the_tables_are_those_of_the_verification(case: str) -> None:
    with (score.REFERENCE / f"{case}.csv").open() as file:
        assert list(csv.reader(file))[1:] == make_tables.rows_of(case)


def test_the_rock_of_energies_is_that_of_our_runs() -> None:
    """By the keys that the runs were made with: another seed or length is another rock."""
    file, *settings = BODIES["slab"]
    case = parse_case(Path(file).read_text(), [str(setting) for setting in settings])
    with (make_tables.ROCK / "energies.csv").open() as file:
        x, y, told = np.array(list(csv.reader(file))[1:], dtype=float).T
    assert len(x) == 51 * 151 and x.max() == 3 and y.max() == 1
    ours = toughness_factor(case)(np.array([x, y, np.zeros_like(x)]))
    assert told == pytest.approx(ours, abs=1e-4)
    assert np.std(ours) == pytest.approx(0.05, rel=0.1)


def test_lengths_are_asked_for_where_the_crack_has_grown() -> None:
    starts = {"length, p = 0.2": 0.1, "length, p = 0.3": 0.12}  # those of README.md
    lengths = [f for f in score.reference() if f.case in ("array", "spacing")]
    assert {f.quantity for f in lengths} > set(starts)
    assert all(f.reference >= 1.15 * starts.get(f.quantity, 0.08) for f in lengths)


def test_the_folder_has_the_license_of_its_scripts() -> None:
    assert (FOLDER / "LICENSE").read_text().endswith((FOLDER.parent / "LICENSE").read_text())


def test_there_is_a_table_for_each_case_and_the_sharp_tables_are_copies() -> None:
    assert {file.stem for file in score.REFERENCE.glob("*.csv")} == set(make_tables.TABLES)
    for file in make_tables.SHARP.glob("*.csv"):
        assert file.read_bytes() == (DATA / file.name).read_bytes()


def test_the_readme_describes_each_figure() -> None:
    told = update_scores.README.read_text()
    assert [f for f in score.reference() if f"`{f.quantity}`" not in told] == []
    assert [name for name in make_tables.TABLES if f"### `{name}`" not in told] == []


@pytest.mark.parametrize("folder", SUBMISSIONS, ids=lambda folder: folder.name)
def test_committed_scores_are_those_of_the_committed_submissions(folder: Path) -> None:
    kept = (update_scores.SCORES / f"{folder.name}.json").read_text()
    assert score.record(folder, score.score(folder)) == kept


def test_the_readme_has_the_scores() -> None:
    begin, end = update_scores.MARKS
    told = update_scores.README.read_text().split(begin)[1].split(end)[0]
    assert told == update_scores.table()

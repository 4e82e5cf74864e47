"""A study on two ranks."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from case.test_bad_input import staffa
from report.test_study import rows
from run.test_study import OVER, SHORT, real  # noqa: F401
from staffa.io.run_directory import open_run


@pytest.mark.slow
def test_members_run_one_after_another_on_all_ranks(real: Path, tmp_path: Path) -> None:
    asked = ("study", "my.toml", *OVER, *SHORT, "--out", str(tmp_path / "s"))
    done = staffa(real, *asked, ranks=2)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("point 2 (member 2 of 2), temperature.severity 12") == 1
    found = rows((tmp_path / "s" / "study.csv").read_text())
    serial = rows((real / "s" / "study.csv").read_text())[::2]
    for row, other in zip(found, serial, strict=True):
        run = open_run(tmp_path / "s" / f"point-{row['point']}" / "seed-3")
        assert run.manifest.ranks == 2
        # The solver stops within its tolerances.
        assert float(row["total_energy"]) == pytest.approx(float(other["total_energy"]), rel=1e-3)
    done = staffa(real, *asked, "--member", "2", ranks=2)
    assert done.returncode == 0 and done.stdout.count("is finished already") == 1, done.stderr


@pytest.mark.slow
def test_jobs_side_by_side_are_refused_under_mpiexec(real: Path, tmp_path: Path) -> None:
    asked = ("study", "my.toml", *OVER, *SHORT, "--out", str(tmp_path / "s"), "--jobs", "2")
    done = staffa(real, *asked, ranks=2)
    assert done.returncode == 2 and done.stderr.count("staffa: ") == 1, done.stderr
    assert "--jobs 2 under mpiexec" in done.stderr and not (tmp_path / "s").exists()

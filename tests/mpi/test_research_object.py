"""On several ranks a run leaves the files, networks and description that one rank leaves."""

import json
from pathlib import Path

import pytest

from run.test_research_object import SHORT, require_valid
from run.test_run import launch
from staffa.io.research_object import crate_files
from support.restarting import SMALL
from support.restarting import launch as launched


@pytest.mark.slow
def test_two_ranks_leave_the_research_object_and_the_networks_of_one(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(SMALL)
    lengths, names = [], []
    for ranks in (1, 2):
        place = tmp_path / f"on-{ranks}"
        done = launch(ranks, "run", tmp_path / "my.toml", "--quiet", "--set", SHORT, "--out", place)
        assert done.returncode == 0, done.stderr
        require_valid(place)
        names.append([file.relative_to(place) for file in crate_files(place)])
        traces = json.loads((place / "network" / "cracks-0001.geojson").read_text())
        lengths.append([line["properties"]["length"] for line in traces["features"]])
    assert names[0] == names[1]
    assert lengths[0] and sorted(lengths[1]) == pytest.approx(sorted(lengths[0]), rel=1e-3)


def test_what_rank_0_does_after_an_error_is_waited_for() -> None:
    code = (
        "from time import sleep\n"
        "from staffa.backend import parallel\n"
        "from staffa.backend.stack import MPI\n"
        "from staffa.errors import StoppedError\n"
        "parallel.TOGETHER, comm = 1.0, MPI.COMM_WORLD\n"
        "def act():\n"
        "    sleep(3.0)\n"
        "    raise OSError('dropped')\n"
        "try:\n"
        "    with parallel.after_error(comm, act):\n"
        "        raise StoppedError('enough')\n"
        "except StoppedError as error:\n"
        "    parallel.require_together(comm, error)\n"
        "    print('together', flush=True)\n"
    )
    done = launched("python", "-c", code, ranks=2, timeout=120)
    assert (done.returncode, done.stdout.count("together")) == (0, 2), done.stderr

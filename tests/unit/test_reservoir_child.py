"""Process of a simulator that ends, hangs or talks nonsense; a small script takes its place."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import staffa.reservoir.message_frames
from staffa.errors import InputError, SolveError, StaffaError, StoppedError
from staffa.reservoir.child import Child, ChildError, environment
from staffa.reservoir.darts import Darts
from staffa.reservoir.interpreter import VARIABLE, answers, simulator_python
from support.paths import TESTS
from support.reservoirs import DAY, fracture_wall

FRAMES = staffa.reservoir.message_frames.__file__
# A server that answers "open", and does what a test says at each step.
SERVER = f"""
import os, runpy, signal, socket, sys, time
sys.path[:0] = {[p for p in sys.path if p]!r}
import numpy as np
frames = runpy.run_path({FRAMES!r})
line = socket.socket(fileno=0)
stream = line.makefile("rb")
def answer(told, arrays=()):
    line.sendall(frames["pack"](told, arrays))
def well(T):
    return dict(mass=1.0, heat=2.0, T=T, pressure=4.0)
while True:
    head, arrays = frames["unpack"](stream.read)
    if head["do"] == "open":
        answer(dict(ok=True, name="pretended 1"), [np.arange(3.0), arrays[-2], arrays[-1]])
        continue
    state = arrays[0]
    print("a step of", head["duration"], flush=True)
    AT_STEP
"""
STEP = """answer(
        dict(ok=True, steps=7, stored=[3.0, 4.0], wells={"in": well(1.0), "out": well(2.0)}),
        [state + 1, np.full(1320, 2e7), np.full(1320, 400.0)],
    )"""
KILL = "os.kill(os.getpid(), signal.SIGKILL)"


def pretended(folder: Path, at_step: str, patience: float = 20.0) -> Darts:
    """Return the simulator with a script in place of open-DARTS."""
    server = folder / "server.py"
    server.write_text(SERVER.replace("AT_STEP", at_step))
    return Darts(fracture_wall(), sys.executable, patience=patience, server=server)


def test_an_answer_is_a_flow_and_an_account(tmp_path: Path) -> None:
    simulator = pretended(tmp_path, STEP)
    first = simulator.start()
    assert simulator.name == "pretended 1"
    flow, account, steps = simulator.advance(first, None, DAY)
    simulator.close()
    assert list(flow.hidden) == [1.0, 2.0, 3.0] and steps == 7
    assert set(flow.p) == {2e7} and set(flow.T) == {400.0}
    assert account.duration == DAY and account.mass_stored == 3.0 and account.heat_stored == 4.0
    assert account.wells["out"].T == 2.0 and account.wells["in"].mass == 1.0


def test_a_process_that_dies_once_is_replaced_and_asked_again(tmp_path: Path) -> None:
    died = tmp_path / "died"
    dies_once = (
        f"if not os.path.exists({str(died)!r}): open({str(died)!r}, 'w'); {KILL}\n    {STEP}"
    )
    simulator = pretended(tmp_path, dies_once)
    flow, _, _ = simulator.advance(simulator.start(), None, DAY)
    assert died.exists() and list(flow.hidden) == [1.0, 2.0, 3.0]
    # Killed between two steps, whether or not the first write to it succeeds.
    for _ in range(3):
        assert simulator.child is not None
        os.kill(simulator.child.process.pid, 9)
        again, _, _ = simulator.advance(flow, None, DAY)
        assert list(again.hidden) == [2.0, 3.0, 4.0]
    simulator.close()


@pytest.mark.parametrize(
    ("at_step", "why"),
    [
        (KILL, "ended with SIGKILL"),
        ("raise ValueError('out of rock')", "ended with exit code 1.*out of rock"),
        ("time.sleep(60)", "no answer within [0-9.]+ s; it said last: a step of 86400"),
        ("line.sendall(b'Traceback (most recent call last)' * 9)", "a line of [0-9]+ bytes"),
        ("answer(['no', 'answer'])", "a message that is no answer"),
        ("line.close(); stream.close(); time.sleep(60)", "it closed its side"),
    ],
)  # fmt: skip
def test_a_process_that_fails_twice_in_a_step_stops_the_run(
    tmp_path: Path, at_step: str, why: str
) -> None:
    simulator = pretended(tmp_path, at_step, patience=0.5 if "sleep" in at_step else 20.0)
    flow = simulator.start()
    with pytest.raises(StoppedError, match=f"failed twice in one step: .*{why}") as found:
        simulator.advance(flow, None, DAY)
    assert found.value.exit_code == 3
    assert simulator.child is None


@pytest.mark.parametrize(
    ("answer", "error", "said"),
    [
        ("converged=False, why='too steep'", SolveError, "did not converge: too steep"),
        ("converged=True, why='no memory'", StaffaError, "simulator failed: no memory"),
    ],
)
def test_a_step_that_fails_within_the_process_is_told(
    tmp_path: Path, answer: str, error: type[StaffaError], said: str
) -> None:
    simulator = pretended(tmp_path, f"answer(dict(ok=False, {answer}))")
    with pytest.raises(error, match=said) as found:
        simulator.advance(simulator.start(), None, DAY)
    assert type(found.value) is error and simulator.child is not None
    simulator.close()


def test_a_process_is_no_rank_and_has_no_settings_of_this_python(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("PMI_RANK", "HYDRA_X", "MPIR_CVAR", "OMPI_X", "PYTHONPATH", "LD_PRELOAD"):
        monkeypatch.setenv(name, "1")
    monkeypatch.setenv("OMP_NUM_THREADS", "8")
    monkeypatch.setenv("HOME", "/home/rock")
    kept = environment()
    assert kept["OMP_NUM_THREADS"] == "1" and kept["HOME"] == "/home/rock"
    assert not [
        n for n in kept if n.startswith(("PMI", "HYDRA", "MPI", "OMPI", "PYTHON", "LD_PRE"))
    ]


def test_the_folder_of_a_process_goes_with_it() -> None:
    child = Child([sys.executable, "-c", "import time; time.sleep(60)"])
    folder, pid = Path(child.folder.name), child.process.pid
    assert os.getsid(pid) == pid != os.getsid(0)
    child.close()
    assert not folder.exists() and child.process.returncode == -9


def test_a_process_that_never_starts_is_wrong_input_and_no_stop() -> None:
    """There is no run yet that could go on."""
    simulator = Darts(fracture_wall(), "/bin/true")
    with pytest.raises(InputError, match=r"/bin/true does not start: it ended .*`staffa doctor`"):
        simulator.start()
    assert simulator.child is None


def test_a_missing_program_is_named() -> None:
    with pytest.raises(ChildError, match="/no/python cannot be started"):
        Child(["/no/python"])
    with pytest.raises(InputError, match=r"/no/python cannot be started .*install open-DARTS"):
        answers("/no/python")


def test_a_python_without_the_simulator_says_so() -> None:
    with pytest.raises(InputError, match=r"does not answer .*No module named 'darts.*install"):
        answers(sys.executable)


def test_the_variable_goes_before_the_key_and_both_must_name_a_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    for path in (one, other):
        path.write_text("#!/bin/sh\n")
        path.chmod(0o755)
    monkeypatch.setenv(VARIABLE, str(one))
    assert simulator_python(other) == one
    monkeypatch.delenv(VARIABLE)
    assert simulator_python(other) == other
    with pytest.raises(InputError, match=r"reservoir\.python = .*gone is no program"):
        simulator_python(tmp_path / "gone")
    with pytest.raises(InputError, match=r"reservoir\.python = bin/python must be a full path"):
        simulator_python("bin/python")
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    with pytest.raises(InputError, match=f"{VARIABLE} = .* is no program.*make reservoir"):
        simulator_python(other)


def test_the_environment_beside_this_one_is_found_or_what_to_install_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(sys, "prefix", str(tmp_path / ".venv"))
    with pytest.raises(InputError, match=r"no reservoir simulator: install .* `make reservoir`"):
        simulator_python()
    beside = tmp_path / ".reservoir" / "bin" / "python"
    beside.parent.mkdir(parents=True)
    beside.write_text("")
    assert simulator_python() == beside


def test_waiting_is_as_long_as_the_last_step_makes_likely(tmp_path: Path) -> None:
    sleepy = f"time.sleep(0.3 if head['duration'] < 100 else 2.0)\n    {STEP}"
    simulator = pretended(tmp_path, sleepy, patience=1.0)
    flow = simulator.start()
    assert simulator.child is not None
    pid = simulator.child.process.pid
    flow, _, _ = simulator.advance(flow, None, 10.0)
    simulator.advance(flow, None, 1000.0)  # 2 s, which is less than 20 times 0.3 s
    assert simulator.child.process.pid == pid
    simulator.close()


def test_fields_of_a_state_can_be_written_to(tmp_path: Path) -> None:
    simulator = pretended(tmp_path, STEP)
    flow, _, _ = simulator.advance(simulator.start(), None, DAY)
    simulator.close()
    np.add(flow.T, 1.0, out=flow.T)
    assert set(flow.T) == {401.0}


ENDS_BY_SIGNAL = """
import signal, sys
import numpy as np
from staffa.reservoir.child import Child, ChildError
signal.signal(signal.SIGPIPE, signal.SIG_DFL)
child = Child([sys.executable, "-c", ""])
child.process.wait()
try:
    child.ask({"do": "step"}, [np.zeros(10**6)])
except ChildError as error:
    print(error)
"""


def test_a_write_to_a_dead_process_is_an_error_and_no_signal() -> None:
    """PETSc ends all ranks at a SIGPIPE; here it would end the process."""
    command = [sys.executable, "-c", ENDS_BY_SIGNAL]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.stdout, done.returncode) == ("it ended with exit code 0\n", 0), done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(("required", "code", "said"), [("0", 0, "1 skipped"), ("1", 1, "1 error")])
def test_without_a_simulator_its_tests_are_skipped_or_where_it_is_required_fail(
    required: str, code: int, said: str
) -> None:
    test = f"{TESTS}/reservoir/test_darts.py::test_it_answers_with_its_version"
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", test]
    environment = os.environ | {VARIABLE: "/no/python", "STAFFA_REQUIRE_DARTS": required}
    done = subprocess.run(
        command, env=environment, cwd=TESTS.parent, capture_output=True, text=True
    )
    assert done.returncode == code and said in done.stdout, done.stdout
    assert "make reservoir" in done.stdout

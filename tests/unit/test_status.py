"""Status of solvers and steps: one enumeration, read from old files and from PETSc's codes."""

import json
from types import SimpleNamespace

from staffa.backend.stack import PETSc, SLEPc

import pytest

from staffa.backend.petsc_status import how_it_ended
from staffa.records.status import Status, Verdict
from staffa.records.step import Curvature, Energies, Step

# As version 0.1.0 wrote them.
OLD = {
    "converged": Status.CONVERGED,
    "not converged": Status.NOT_CONVERGED,
    "failed": Status.FAILED,
    "rejected": Status.REJECTED,
}


def step(status: Status) -> Step:
    """A step that ended so."""
    energies = Energies(elastic=1.0, surface=0.0)
    return Step(
        index=0, time=1.0, tau=None, energies=energies, sweeps=1, status=status, reason="said"
    )


@pytest.mark.parametrize("value", OLD)
def test_what_version_0_1_0_wrote_is_read_and_written_again_as_it_was(value: str) -> None:
    line = json.dumps(step(OLD[value]).to_record())
    assert f'"status": "{value}"' in line
    found = Step.from_record(json.loads(line))
    assert found.status is OLD[value] and found == step(OLD[value])


def test_a_status_that_is_none_is_refused() -> None:
    record = step(Status.CONVERGED).to_record() | {"status": "bored"}
    with pytest.raises(ValueError, match="status"):
        Step.from_record(record)


def test_each_status_has_a_sentence_of_its_own() -> None:
    sentences = {said.sentence for said in (*Status, *Verdict)}
    assert len(sentences) == len(Status) + len(Verdict)
    assert all(sentence and not sentence.endswith(".") for sentence in sentences)


def test_a_verdict_is_read_off_what_a_file_holds() -> None:
    for curvature, verdict in (
        (Curvature(smallest=0.4), Verdict.MINIMUM),
        (Curvature(), Verdict.MINIMUM),  # no damage may move
        (Curvature(smallest=-0.1, bifurcation=True, reason="a bifurcation"), Verdict.BIFURCATION),
        (Curvature(smallest=-0.1, reason="left 3 times"), Verdict.SADDLE),
        (Curvature(reason="not tested: it is held"), Verdict.NOT_TESTED),
    ):
        assert curvature.verdict is verdict


SOLVERS = [PETSc.KSP, PETSc.SNES, PETSc.TAO, SLEPc.EPS]


@pytest.mark.parametrize("kind", SOLVERS, ids=lambda kind: kind.__name__)
def test_every_reason_of_petsc_is_a_status(kind) -> None:
    codes = {n: v for n, v in vars(kind.ConvergedReason).items() if isinstance(v, int)}
    for code in codes.values():
        solver = SimpleNamespace(
            ConvergedReason=kind.ConvergedReason, getConvergedReason=lambda code=code: code
        )
        end = how_it_ended(solver)
        assert end.converged == (code > 0), end
        assert codes[end.name] == code and end.name in end.sentence


def test_a_solver_tells_why_it_failed() -> None:
    """Conjugate gradients that may not iterate enough, and on a matrix that is not positive."""
    for diagonal, most, status in (
        ([1.0, 2.0, 3.0, 4.0], 1, Status.NOT_CONVERGED),
        ([1.0, -2.0, 3.0, 4.0], 99, Status.INDEFINITE),
        ([1.0, 2.0, 3.0, 4.0], 99, Status.CONVERGED),
    ):
        matrix = PETSc.Mat().createAIJ((4, 4), nnz=1, comm=PETSc.COMM_SELF)
        for row, value in enumerate(diagonal):
            matrix.setValue(row, row, value)
        matrix.assemble()
        ksp = PETSc.KSP().create(PETSc.COMM_SELF)
        ksp.setType("cg")
        ksp.pc.setType("none")
        ksp.setOperators(matrix)
        ksp.setTolerances(rtol=1e-12, max_it=most)
        b, x = matrix.createVecs()
        b.set(1.0)
        ksp.solve(b, x)
        assert how_it_ended(ksp).status is status
        for thing in (ksp, matrix, b, x):
            thing.destroy()

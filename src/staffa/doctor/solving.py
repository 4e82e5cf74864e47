"""What solves: the finite-element stack, its parts, and a run on two ranks."""

import json
import shutil
import sys
import tempfile
from pathlib import Path

from staffa.backend import isolation
from staffa.case.reading import ready_cases
from staffa.doctor.child import python, spoken
from staffa.errors import StaffaError
from staffa.io.run_directory import read_run

LIBRARIES = """
import json
from staffa.backend.stack import MPI, PETSc, SLEPc
import dolfinx, mpi4py, petsc4py, slepc4py, ufl
found = {m.__name__: m.__version__ for m in (dolfinx, petsc4py, slepc4py, mpi4py)}
print(json.dumps(found | {"MPI": " ".join(MPI.Get_library_version().splitlines()[0].split())}))
"""
PETSC = """
from staffa.backend.stack import PETSc
print(PETSc.Sys.hasExternalPackage("mumps"))
"""
PARTITIONERS = """
from staffa.backend.stack import MPI
import dolfinx
print(*(name for name in ("ptscotch", "parmetis", "kahip") if getattr(dolfinx, f"has_{name}")))
"""
# One rank alone speaks: the launcher may mix what two say.
SIZE = """
from staffa.backend.stack import MPI
if MPI.COMM_WORLD.rank == 0:
    print(MPI.COMM_WORLD.size)
"""
STAFFA = "from staffa.cli import main; main()"
SMALL = ("domain.h=0.05", "time.t=[0.1,0.9]", "output.at=[]", "solver.guess=none")
FROM_WHERE = "install DOLFINx anew, as docs/cluster.md says"


def libraries() -> str:
    """DOLFINx, PETSc, SLEPc and MPI load together."""
    try:
        found = json.loads(python(LIBRARIES))
    except StaffaError as error:
        raise StaffaError(
            f"the finite-element stack does not load ({error}); {FROM_WHERE}"
        ) from None
    return ", ".join(f"{name} {version}" for name, version in found.items())


def petsc() -> str:
    """PETSc has the direct solver."""
    if python(PETSC).strip() != "True":
        raise StaffaError(f"PETSc was built without MUMPS, the direct solver; {FROM_WHERE}")
    return "with MUMPS"


def partitioner() -> str:
    """DOLFINx can share a mesh out."""
    found = python(PARTITIONERS).split()
    if not found:
        raise StaffaError(f"DOLFINx was built without a partitioner of meshes; {FROM_WHERE}")
    return ", ".join(found)


def mpiexec() -> str:
    """The launcher starts ranks that see one another."""
    launcher = _launcher()
    try:
        size = python(SIZE, launcher=[launcher, "-n", "2"]).strip()
    except StaffaError as error:
        raise StaffaError(f"{launcher} starts no two ranks ({error}); {FROM_WHERE}") from None
    if size != "2":
        raise StaffaError(
            f"{launcher} starts ranks that do not see one another: it belongs to another MPI than "
            f"mpi4py; use the mpiexec that came with that"
        )
    return launcher


def _launcher() -> str:
    found = shutil.which("mpiexec")
    if found is None:
        beside = Path(sys.executable).parent
        way_out = (
            f"put {beside} in it" if (beside / "mpiexec").exists() else "install that of your MPI"
        )
        raise StaffaError(f"there is no mpiexec in PATH, which starts several ranks; {way_out}")
    return found


def two_ranks() -> str:
    """A small run on two ranks comes to its end; the first one compiles its forms."""
    with tempfile.TemporaryDirectory() as name:
        case, directory = Path(name) / "bar.toml", Path(name) / "run"
        case.write_text(ready_cases.text("bar"), encoding="utf-8")
        settings = [word for setting in SMALL for word in ("--set", setting)]
        launch = [_launcher(), "-n", "2", *isolation.isolated_python(STAFFA)]
        asked: list[str | Path] = ["run", case, "--out", directory, "--quiet", *settings]
        spoken([*launch, *asked], seconds=300, folder=Path(name))
        run = read_run(directory)
    said = [sentence for step in run.steps if step.audit for sentence in step.audit.violations]
    if said or not run.finished or not run.steps[-1].energies.surface > 0:
        raise StaffaError(
            f"a small run on two ranks ended wrongly ({said[0] if said else 'nothing broke'}); "
            f"{FROM_WHERE}"
        )
    return f"the ready case bar, {run.manifest.unknowns:,} unknowns, breaks as it should"

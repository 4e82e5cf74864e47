"""Commands that run a case many times: `ensemble` and `study`."""

import os
from pathlib import Path
from typing import Annotated

import typer

from staffa.cli.options import (
    CaseFile,
    FirstSeed,
    Jobs,
    MemberNumber,
    Outside,
    Quiet,
    Settings,
    SlurmScript,
    WallTime,
)
from staffa.errors import EXIT_CODES, InputError

# Variables in which launchers give a process its rank: MPICH and Intel MPI, Open MPI, PMIx.
RANK = ("PMI_RANK", "OMPI_COMM_WORLD_RANK", "PMIX_RANK")

many_runs = typer.Typer()


@many_runs.command(epilog=EXIT_CODES)
def ensemble(
    case_file: CaseFile,
    seeds: Annotated[
        int, typer.Option("--seeds", help="how many members, 2 or more", show_default=False)
    ],
    first: FirstSeed = None,
    directory: Annotated[
        Path | None,
        typer.Option("--out", help="its directory; default runs/<case file's name>-ensemble"),
    ] = None,
    settings: Settings = None,
    outside: Outside = False,
    jobs: Jobs = 1,
    slurm: SlurmScript = None,
    member: MemberNumber = None,
    wall_time: WallTime = None,
    quiet: Quiet = False,
) -> None:
    """Run a case with several seeds, for means and errors; finished members are kept."""
    from staffa.case.reading.read import read_case
    from staffa.cli.walltime import wall_time_seconds

    limit = wall_time_seconds(wall_time)
    _require_one_way(jobs, slurm, member)
    from staffa.cli.members import Way, run_members_and_follow  # loads the finite-element stack

    where = directory or Path("runs") / f"{case_file.stem}-ensemble"
    words = ["ensemble", *_common_words(case_file, where, settings, outside, seeds, first)]
    run_members_and_follow(
        lambda: read_case(case_file, settings or [], outside=outside),
        where,
        count=seeds,
        first=first,
        way=Way(quiet=quiet, wall_time=limit, jobs=jobs, member=member, words=words, script=slurm),
    )


@many_runs.command(epilog=EXIT_CODES)
def study(
    case_file: CaseFile,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            help='section.key=VALUES: "40:90:6 J/m^2" (from, to, how many), "40, 60 J/m^2", or a '
            "list of TOML; several make a grid",
        ),
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option(
            "--samples",
            help='points of a Latin hypercube in ranges, --over section.key="40:100 J/m^2"',
            show_default=False,
        ),
    ] = None,
    sampling_seed: Annotated[
        int, typer.Option("--sampling-seed", min=0, help="seed of the Latin hypercube")
    ] = 0,
    seeds: Annotated[int, typer.Option("--seeds", help="seeds of the rock at each point")] = 1,
    first: FirstSeed = None,
    directory: Annotated[
        Path | None,
        typer.Option("--out", help="its directory; default runs/<case file's name>-study"),
    ] = None,
    settings: Settings = None,
    outside: Outside = False,
    jobs: Jobs = 1,
    slurm: SlurmScript = None,
    member: MemberNumber = None,
    wall_time: WallTime = None,
    quiet: Quiet = False,
) -> None:
    """Run a case over values of its keys: tables and response curves; finished runs are kept."""
    from staffa.case.reading.read import read_case
    from staffa.cli.walltime import wall_time_seconds

    limit = wall_time_seconds(wall_time)
    _require_one_way(jobs, slurm, member)
    from staffa.case.reading.study_points import study_points
    from staffa.cli.members import Way, run_study_and_follow  # loads the finite-element stack

    where, chosen = directory or Path("runs") / f"{case_file.stem}-study", tuple(over or ())
    words = ["study", *_common_words(case_file, where, settings, outside, seeds, first)]
    words += [word for text in chosen for word in ("--over", text)]
    if samples is not None:
        words += ["--samples", str(samples), "--sampling-seed", str(sampling_seed)]
    run_study_and_follow(
        lambda more: read_case(case_file, [*(settings or ()), *more], outside=outside),
        where,
        over=lambda: study_points(chosen, samples=samples, seed=sampling_seed),
        count=seeds,
        first=first,
        way=Way(quiet=quiet, wall_time=limit, jobs=jobs, member=member, words=words, script=slurm),
    )


def _common_words(
    case_file: Path,
    directory: Path,
    settings: list[str] | None,
    outside: bool,
    seeds: int,
    first: int | None,
) -> list[str]:
    """Return the arguments that another process needs to do the same."""
    words = [str(case_file), "--out", str(directory), "--seeds", str(seeds)]
    words += ["--first", str(first)] if first is not None else []
    words += [word for text in settings or () for word in ("--set", text)]
    return words + (["--outside"] if outside else [])


def _require_one_way(jobs: int, slurm: Path | None, member: int | None) -> None:
    """Refuse options that do not go together, before anything is loaded."""
    if jobs < 1:
        raise InputError(f"--jobs {jobs}: at least 1 member runs at a time; give 1 or more")
    given = {"--jobs": jobs > 1, "--slurm": slurm is not None, "--member": member is not None}
    both = [name for name, is_given in given.items() if is_given]
    if len(both) > 1:
        raise InputError(f"{both[0]} and {both[1]} do not go together; give one of them")
    if jobs > 1 and any(name in os.environ for name in RANK):
        raise InputError(
            f"--jobs {jobs} under mpiexec: the ranks run the members one after another; leave out "
            f"--jobs, or mpiexec"
        )
    if slurm is not None:
        from staffa.cli.slurm_script import require_new_script

        require_new_script(slurm)

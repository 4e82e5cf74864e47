"""Commands, their arguments and their output."""

import json
import os
import sys
import warnings
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from staffa.cli.many_runs import RANK, many_runs
from staffa.cli.options import (
    CaseFile,
    Folder,
    Outside,
    Quiet,
    RunFolder,
    RunOrEnsemble,
    Settings,
    WallTime,
)
from staffa.cli.terminal import out, to_a_terminal_that_may_close
from staffa.errors import EXIT_CODES, InputError, StaffaError, StaffaWarning, printable

# Each command imports what it needs by itself, so that `staffa --help` answers at once.
app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Predicts how cooling cracks rock.",
    epilog=EXIT_CODES,
)
app.add_typer(many_runs)


@app.command()
def cases() -> None:
    """List the ready cases."""
    from staffa.case.reading import ready_cases

    table = Table(box=None, show_header=False)
    for name in ready_cases.ready_case_names():
        table.add_row(f"[bold]{name}[/bold]", escape(ready_cases.ready_case(name).title))
    out.print(table)


@app.command()
def new(
    case: Annotated[str, typer.Argument(help="name of a ready case", show_default=False)],
) -> None:
    """Write a ready case to the terminal, every key explained: staffa new slab > my.toml."""
    from staffa.case.reading import ready_cases
    from staffa.case.schema.toml_text import to_toml

    print(to_toml(ready_cases.ready_case(case), explained=True), end="")


@app.command()
def schema() -> None:
    """Write the JSON schema of a case, for editors: staffa schema > case.schema.json."""
    from staffa.case.schema.case import Case

    print(json.dumps(Case.model_json_schema(), indent=1, ensure_ascii=False))


@app.command()
def check(case_file: CaseFile, settings: Settings = None, outside: Outside = False) -> None:
    """Print the physics and the cost of a case before it runs."""
    from staffa.case.check.preview import preview
    from staffa.case.reading.read import read_case

    case = read_case(case_file, settings or [], outside=outside)
    said = preview(case)
    if case.title:
        out.print(f"[bold]{escape(case.title)}[/bold]")
    table = Table(box=None, show_header=False)
    for name, value, meaning in said.facts:
        table.add_row(name, f"[bold]{escape(value)}[/bold]", f"[dim]{escape(meaning)}[/dim]")
    out.print(table)
    for sentence in said.warnings:
        out.print(f"[yellow]warning:[/yellow] {escape(sentence)}")
    for sentence in said.notes:
        out.print(f"[cyan]note:[/cyan] {escape(sentence)}")
    out.print(f"[{'yellow' if said.warnings else 'green'}]{said.verdict}[/]")


@app.command("run", epilog=EXIT_CODES)
def run_command(
    case_file: CaseFile,
    directory: Annotated[
        Path | None, typer.Option("--out", help="run directory; default runs/<case file's name>")
    ] = None,
    settings: Settings = None,
    outside: Outside = False,
    wall_time: WallTime = None,
    quiet: Quiet = False,
) -> None:
    """Run a case, also under mpiexec -n N."""
    from staffa.case.reading.read import read_case
    from staffa.cli.walltime import wall_time_seconds

    limit = wall_time_seconds(wall_time)
    from staffa.cli.live import run_and_follow  # loads the finite-element stack

    where = directory or Path("runs") / case_file.stem
    run_and_follow(
        lambda: read_case(case_file, settings or [], outside=outside),
        where,
        quiet=quiet,
        wall_time=limit,
    )


@app.command(epilog=EXIT_CODES)
def demo(
    directory: Annotated[Path, typer.Option("--out", help="run directory")] = Path("runs/demo"),
    settings: Settings = None,
    wall_time: WallTime = None,
    quiet: Quiet = False,
) -> None:
    """Run the demonstration, the ready case slab: a table and pictures in minutes."""
    from staffa.case.reading import ready_cases
    from staffa.cli.walltime import wall_time_seconds

    limit = wall_time_seconds(wall_time)
    from staffa.cli.live import run_and_follow  # loads the finite-element stack

    run_and_follow(
        lambda: ready_cases.ready_case("slab", settings or []),
        directory,
        quiet=quiet,
        wall_time=limit,
    )


@app.command("resume", epilog=EXIT_CODES)
def resume_command(
    directory: Annotated[Path, typer.Argument(help="directory of a run", show_default=False)],
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="section.key=value; of time, output and solver alone"),
    ] = None,
    wall_time: WallTime = None,
    quiet: Quiet = False,
) -> None:
    """Continue a run that was stopped or killed, also under mpiexec -n N."""
    from staffa.cli.walltime import wall_time_seconds
    from staffa.io.ensemble_directory import is_ensemble
    from staffa.io.study_directory import is_study

    limit = wall_time_seconds(wall_time)
    of = "study" if is_study(directory) else "ensemble" if is_ensemble(directory) else None
    if of is not None:
        raise InputError(
            f"{directory} is {'a' if of == 'study' else 'an'} {of}; give its `staffa {of}` command "
            f"again with --out {directory}: members that are finished are taken, and others go on"
        )
    from staffa.cli.live import resume_and_follow  # loads the finite-element stack

    resume_and_follow(directory, settings=settings or [], quiet=quiet, wall_time=limit)


@app.command()
def show(directory: Folder) -> None:
    """Show the summary of a run, an ensemble or a study, also of one that is not finished."""
    from staffa.cli.results import print_ensemble, print_study, print_summary
    from staffa.io.ensemble_directory import is_ensemble, read_ensemble
    from staffa.io.run_directory import open_run
    from staffa.io.study_directory import is_study, read_study

    if is_study(directory):
        print_study(read_study(directory))
    elif is_ensemble(directory):
        print_ensemble(read_ensemble(directory))
    else:
        print_summary(open_run(directory))


@app.command()
def report(
    directory: Folder,
    movie: Annotated[
        bool | None,
        typer.Option(
            "--movie/--no-movie",
            help="with pictures/growing.gif, the cracks growing; default in 3-D only",
            show_default=False,
        ),
    ] = None,
    members: Annotated[
        bool, typer.Option("--members", help="also those of each run of an ensemble or a study")
    ] = False,
) -> None:
    """Draw the pictures and the page of a run, an ensemble or a study again."""
    from staffa.cli.results import (  # loads Matplotlib
        print_ensemble_pictures,
        print_pictures,
        print_study_pictures,
    )
    from staffa.io.ensemble_directory import is_ensemble, read_ensemble
    from staffa.io.run_directory import open_run
    from staffa.io.study_directory import is_study, read_study

    study = read_study(directory) if is_study(directory) else None
    ensemble = read_ensemble(directory) if study is None and is_ensemble(directory) else None
    several = study or ensemble
    if several is None and members:
        raise InputError(f"--members: {directory} is one run; leave out --members")
    if several is not None and movie and not members:
        raise InputError(
            f"--movie shows the cracks of one run, and {directory} has several: add --members, or "
            f"give the directory of one of its members"
        )
    if several is None:
        print_pictures(open_run(directory), movie=movie)
    for run in several.runs.values() if several and members else ():
        print_pictures(run, movie=movie)
    if study is not None:
        print_study_pictures(study)
    elif ensemble is not None:
        print_ensemble_pictures(ensemble)


@app.command()
def compare(
    one: RunFolder,
    other: RunFolder,
    directory: Annotated[
        Path | None,
        typer.Option("--out", help="where the page goes; default runs/<one>-vs-<other>"),
    ] = None,
) -> None:
    """Compare two finished runs in numbers and pictures: do they agree, and until when?"""
    from staffa.cli.results import print_pair, print_pair_pictures  # loads Matplotlib
    from staffa.compare.open_pair import place_of, read_pair

    pair = read_pair(one, other)
    place = place_of(pair, directory)
    print_pair(pair)
    print_pair_pictures(pair, place)


@app.command()
def export(
    directory: RunOrEnsemble,
    as_zip: Annotated[
        bool, typer.Option("--zip", help="pack it into one file, an RO-Crate in a zip archive")
    ] = False,
    archive: Annotated[
        Path | None, typer.Option("--out", help="the archive; default DIRECTORY.zip")
    ] = None,
) -> None:
    """Describe a run or an ensemble as a research object (RO-Crate); with --zip also pack it."""
    from staffa.io.crate_archive import described, export_zip

    if archive is not None and not as_zip:
        raise InputError(f"--out {archive} is for an archive; add --zip, or leave it out")
    made = export_zip(directory, archive) if as_zip else described(directory)
    print(printable(str(made)))


@app.command()
def doctor() -> None:
    """Check the installation, from the compiler to a run on two ranks; exit code 1 if it fails."""
    from staffa.doctor import LACKING, OK, UNTRIED, WRONG, checkup

    colors = {OK: "green", LACKING: "yellow", UNTRIED: "yellow", WRONG: "red"}
    found = []
    for finding in checkup():
        found.append(finding.verdict)
        verdict = f"[{colors[finding.verdict]}]{finding.verdict:<8}[/]"
        out.print(f"{verdict} {finding.name:<12} {escape(finding.said)}", soft_wrap=True)
    if WRONG in found:
        raise typer.Exit(1)


def main() -> None:
    """Run the command line; errors of staffa are one sentence, on rank 0, with an exit code."""
    if not _is_first():
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115 (till the end)
    os.environ["MPLBACKEND"] = "agg"  # pictures go to files, whatever is asked for
    warnings.showwarning = _warn
    try:
        with to_a_terminal_that_may_close():
            _require_docstrings()
            app()
    except StaffaError as error:
        if _is_first():
            print(f"staffa: {error}", file=sys.stderr)
        raise SystemExit(error.exit_code) from None
    except Exception:
        sys.stderr = sys.__stderr__
        raise


def _require_docstrings() -> None:
    if sys.flags.optimize > 1:
        raise InputError(
            f"PYTHONOPTIMIZE = {sys.flags.optimize} takes away docstrings of libraries, without "
            f"which some of them do not load; unset it, or set it to 1"
        )


def _warn(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
    """Show a warning of staffa as one sentence, and none of a library."""
    if issubclass(category, StaffaWarning) and sys.stderr is not None:
        print(f"staffa: {printable(str(message))}", file=sys.stderr)


def _is_first() -> bool:
    """Return True on rank 0, or the only rank; also before MPI is loaded."""
    if "mpi4py.MPI" in sys.modules:
        return bool(sys.modules["mpi4py.MPI"].COMM_WORLD.rank == 0)
    return next((os.environ[name] for name in RANK if name in os.environ), "0") == "0"

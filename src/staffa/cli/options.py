"""Arguments and options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

CaseFile = Annotated[Path, typer.Argument(help="a case file (TOML)", show_default=False)]
Settings = Annotated[
    list[str] | None, typer.Option("--set", help="section.key=value, put over the case")
]
Outside = Annotated[
    bool, typer.Option("--outside", help="the case may name files outside its folder")
]
Folder = Annotated[
    Path, typer.Argument(help="directory of a run, an ensemble or a study", show_default=False)
]
RunOrEnsemble = Annotated[
    Path, typer.Argument(help="directory of a run or an ensemble", show_default=False)
]
RunFolder = Annotated[
    Path, typer.Argument(metavar="RUN", help="directory of a finished run", show_default=False)
]
WallTime = Annotated[
    str | None,
    typer.Option(
        "--wall-time", help='stop and save before this time is over, like "12 h"; exit code 3'
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="print errors only, draw no pictures")]
FirstSeed = Annotated[
    int | None, typer.Option("--first", help="the first seed; default the case's own")
]
Jobs = Annotated[
    int, typer.Option("--jobs", help="members that run side by side, each in a separate process")
]
MemberNumber = Annotated[
    int | None,
    typer.Option(
        "--member",
        help="run this member alone, counted from 1, as a job of an array does",
        show_default=False,
    ),
]
SlurmScript = Annotated[
    Path | None,
    typer.Option(
        "--slurm",
        help="write a script for a Slurm job array here, a job for each member, and run none; "
        "a study is planned: its study.json is written",
        show_default=False,
    ),
]

"""Script of a Slurm job array that runs the members of an ensemble or a study."""

import os
from collections.abc import Sequence
from math import ceil
from pathlib import Path
from shlex import join, quote

from staffa.errors import InputError, StaffaError
from staffa.io.own_files import write_aside

HOURS = 24.0  # of a job, where no wall time is given
SPARE = 12.0  # minutes between the wall time of a run and the limit of its job
SCRIPT = """\
#!/bin/bash
#SBATCH --job-name={name}
#SBATCH --output={name}-%a.log
#SBATCH --array=1-{count}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu=4G
#SBATCH --time={minutes}
# Each job of the array runs one member. Submit it from this folder, with the environment of staffa
# active, or activate it below: sbatch {script}
# For jobs that were stopped or failed, submit it again: runs go on, finished ones are left as they
# are. Members of more ranks: --ntasks. Fewer jobs at a time: --array=1-{count}%4.
# Once all are over: {report}

set -euo pipefail

# source "$HOME/miniforge3/bin/activate" staffa
export OMP_NUM_THREADS=1  # threads of OpenBLAS would compete with the ranks for the same cores

launch=""
if [ "${{SLURM_NTASKS:-1}}" -gt 1 ]; then launch=srun; fi
exec $launch {command} --member "$SLURM_ARRAY_TASK_ID"
"""


def require_new_script(script: Path) -> None:
    """Refuse a script that is there already, or that cannot be written there.

    Raises
    ------
    InputError
        It is, or it cannot.
    """
    _require_printable("--slurm", script)
    if script.exists() or script.is_symlink():
        raise InputError(f"--slurm {script} is there already; choose another name, or remove it")
    if not script.parent.is_dir():
        raise InputError(f"--slurm {script}: there is no folder {script.parent}; make it first")
    if not os.access(script.parent, os.W_OK):
        raise InputError(
            f"--slurm {script}: you may not write to {script.parent}; choose another folder"
        )


def _require_printable(option: str, path: Path) -> None:
    """Refuse a name that would end a comment of the script, as one with a line break does."""
    if not str(path).isprintable():
        raise InputError(
            f"{option} {str(path)!r}: the script cannot have a name with characters that are not "
            f"printable; choose another name"
        )


def write_slurm_script(
    script: Path, words: Sequence[str], count: int, directory: Path, wall_time: float | None
) -> None:
    """Write the script.

    Parameters
    ----------
    script : the file.
    words : arguments of the command, without those of one member.
    count : number of members.
    directory : directory of the ensemble or the study.
    wall_time : longest time of each member (s); None for a day.

    Raises
    ------
    InputError
        The name of the directory has characters that are not printable.
    StaffaError
        It cannot be written.
    """
    _require_printable("--out", directory)
    seconds = 3600 * HOURS - 60 * SPARE if wall_time is None else wall_time
    command = ["staffa", *words, "--wall-time", f"{seconds:.0f} s"]
    text = SCRIPT.format(
        name="".join(c if c.isalnum() else "-" for c in directory.resolve().name) or "staffa",
        count=count,
        minutes=ceil(seconds / 60 + SPARE),
        script=quote(str(script)),
        report=join(["staffa", "report", str(directory)]),
        command=join(command),
    )
    try:
        write_aside(script, text)
        script.chmod(0o755)
    except OSError as error:
        raise StaffaError(
            f"{script} cannot be written: {error.strerror}; choose another name with --slurm"
        ) from None

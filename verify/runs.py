"""Runs from the command line, as a user starts them, kept in runs/verify."""

import shutil
import subprocess
import sys
from pathlib import Path

from staffa.io.run_directory import Run, read_run

HERE = Path(__file__).parent
ROOT = HERE.parent


def ready_case(name: str, folder: str, *settings: str) -> Run:
    """A ready case run from the command line, in runs/verify."""
    where = ROOT / "runs" / "verify" / folder
    shutil.rmtree(where, ignore_errors=True)
    case = ROOT / "src" / "staffa" / "cases" / f"{name}.toml"
    command = [f"{Path(sys.executable).parent}/staffa", "run", f"{case}", "--out", f"{where}"]
    subprocess.run([*command, "--quiet", *(f"--set={s}" for s in settings)], check=True)
    return read_run(where)

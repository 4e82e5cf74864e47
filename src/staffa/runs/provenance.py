"""Provenance for the manifest: version, commit and date."""

import subprocess
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from pathlib import Path


def version() -> str:
    """Return the version of the installed package."""
    try:
        return installed("staffa")
    except PackageNotFoundError:
        return "not installed"


def commit() -> str | None:
    """Return the commit of this source, marked if it was changed; None outside a checkout."""
    source = Path(__file__).parents[2]
    if not (source.parent / ".git").exists():  # a folder above may be foreign, and git runs
        return None  # the commands in its settings
    try:
        described = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"],
            cwd=source,
            capture_output=True,
            text=True,
            timeout=10,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return described.stdout.strip() or None


def now() -> str:
    """Return date and time in UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")

"""The tutorial's scripts run as they stand."""

import re
from pathlib import Path

import pytest

from support.paths import DOCS

PAGE = DOCS / "how-to" / "extending.md"


@pytest.mark.slow
def test_the_scripts_of_the_tutorial_run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """One after the other, as a reader would type them."""
    monkeypatch.chdir(tmp_path)
    known: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(blocks) == 9
    for block in blocks:
        exec(compile(block, PAGE.name, "exec"), known)
    assert len(capsys.readouterr().out.splitlines()) == 9

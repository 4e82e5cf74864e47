"""Scripts for Slurm and processes side by side: the rules that need no run."""

import os
import signal
from dataclasses import replace
from pathlib import Path

from case.test_bad_input import check_sentence, sentence_of
from report.test_report import drawn_run, rewritten
from staffa.case.reading.read import parse_case
from staffa.cli.jobs import _end_with_parent, _is_complete
from staffa.cli.slurm_script import require_new_script, write_slurm_script
from staffa.records.status import Status
from staffa.runs.member_runs import Member
from support.restarting import SMALL


def test_a_name_that_would_end_a_comment_of_the_script_is_refused(tmp_path: Path) -> None:
    said = sentence_of(lambda: require_new_script(tmp_path / "job\nrm -r x.sh"))
    check_sentence(said, "not printable", "choose another name")
    script = tmp_path / "job.sh"
    said = sentence_of(lambda: write_slurm_script(script, (), 2, Path("a\nrm -r x"), None))
    check_sentence(said, "--out 'a\\nrm -r x'", "not printable")
    assert not script.exists()


def test_a_folder_that_cannot_be_written_to_is_refused_before_all(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    check_sentence(
        sentence_of(lambda: require_new_script(tmp_path / "job.sh")), "you may not write"
    )


def test_a_process_whose_parent_is_gone_before_it_begins_ends_at_once(monkeypatch) -> None:
    asked, ended = [], []
    monkeypatch.setattr(os, "_exit", ended.append)
    _end_with_parent(lambda *words: asked.append(words) or 0, os.getppid())
    assert asked == [(1, signal.SIGTERM)] and ended == []
    _end_with_parent(lambda *words: 0, os.getppid() + 1)
    assert ended == [143]


def test_a_member_that_failed_at_its_last_step_is_not_finished(tmp_path: Path) -> None:
    run = drawn_run(tmp_path / "seed-0", n=6)
    case, place = parse_case(SMALL), run.path
    member = Member(number=1, label="seed 0", case=case, place=place, finished=None, warns=False)
    assert _is_complete(member)
    last = replace(run.steps[-1], status=Status.NOT_CONVERGED, reason="out of sweeps")
    rewritten(run, [*run.steps[:-1], last])
    assert not _is_complete(member)
    assert not _is_complete(replace(member, place=tmp_path / "none"))

"""Systems left by a test are destroyed after it; kept and destroyed ones are left alone."""

import pytest

from staffa.evolution.system import System, build
from support.bodies import body
from support.systems import destroyed_when_left


def small() -> System:
    return build(body((1.0, 1.0), 0.5))


def test_a_system_left_behind_is_destroyed() -> None:
    with destroyed_when_left():
        system = small()
        parts = system.alternation
        del system
        assert parts.u, "not before the test is over"
    assert not parts.u and not parts.elastic.stiffness


def test_a_system_that_something_keeps_is_not_destroyed() -> None:
    with destroyed_when_left():
        kept = small()
    assert kept.alternation.u
    kept.destroy()


def test_a_destroyed_system_is_not_destroyed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    with destroyed_when_left():
        system = small()
        system.destroy()
        again: list[System] = []
        monkeypatch.setattr(System, "destroy", again.append)
        del system
    assert not again

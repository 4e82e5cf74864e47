"""Output fields on several ranks."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from run.test_output_fields import FIELDS, in_order, pulled, written
from support.bodies import RANKS
from support.ranks import printed_on

ON_RANKS = """
from pathlib import Path
from run.test_output_fields import pulled, written
written(pulled(), Path({file!r}))
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_fields_are_the_same_on_any_ranks(ranks: int, tmp_path: Path) -> None:
    alone = written(pulled(), tmp_path / "1.vtkhdf")
    printed_on(ranks, ON_RANKS.format(file=str(tmp_path / "n.vtkhdf")))
    one, other = (in_order(path) for path in (alone, tmp_path / "n.vtkhdf"))
    assert one.keys() == other.keys() == FIELDS.keys()
    for name, values in one.items():
        assert other[name] == pytest.approx(values, rel=1e-9, abs=1e-12), name

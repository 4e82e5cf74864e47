"""The commands of the runs that are kept: their case is still accepted, and has that ell and nu."""

import pytest

from staffa.errors import InputError
from support.kept_runs import as_run, kept_records


def test_the_commands_of_kept_runs_can_still_be_typed() -> None:
    records = list(kept_records())
    refused, other, compared = {}, {}, 0
    for record in records:
        command = record["command"]
        try:
            case, _ = as_run(command)
        except InputError as error:
            refused[command] = str(error)
            continue
        now = {"ell": case.damage.ell, "nu": case.material.nu}
        for key in now.keys() & record.keys():
            compared += 1
            if now[key] != pytest.approx(record[key]):
                other[command] = f"{key} = {now[key]}, kept: {record[key]}"
    assert len(records) > 80 and compared > 60
    assert not refused, refused
    assert not other, other

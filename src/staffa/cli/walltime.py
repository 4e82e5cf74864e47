"""Wall time as given on the command line."""

from staffa.errors import InputError
from staffa.units import Quantity, parse


def wall_time_seconds(text: str | None) -> float | None:
    """Return the seconds of a wall time with its unit, like "12 h"; None for None.

    Raises
    ------
    InputError
        The text is no time.
    """
    if text is None:
        return None
    try:
        found: Quantity | None = parse(text, "time")
    except InputError:
        found = None
    if found is None or not found > 0:
        raise InputError(
            f"--wall-time {text}: it must be a time larger than zero, with its unit; write it like "
            f'--wall-time "12 h"'
        )
    return float(found)

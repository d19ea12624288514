"""What mends a clock that does not rise: which rows may go, and which must not be sorted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# part of the rows that repeat a stamp from which on it is the clock that is coarse
TICKS = 0.1


def _again(columns: dict[str, Array]) -> bool:
    """Whether rows of a repeated time hold the same numbers, so that nothing is lost without them."""
    same = np.diff(columns["time_s"]) == 0.0
    return all(bool(np.array_equal(v[1:][same], v[:-1][same], equal_nan=True)) for v in columns.values() if len(v) == len(same) + 1)


def mend_backward(step: Array, fewest: int) -> str:
    """Return what mends a time that runs backwards: a clock that began anew (each part has ``fewest`` samples), or rows in another order."""
    forward = step[step > 0.0]
    period = float(np.median(forward)) if len(forward) else 0.0
    back = -step[step < 0.0]
    if len(back) and bool(np.all(back > fewest * period)) and len(back) * fewest < len(step):
        return 'import with [time] backward = "split": the clock began anew, and sorted by time both parts would be mixed'
    return "sort the rows by their clock or number before the import"


def mend_repeated(step: Array, columns: dict[str, Array]) -> str:
    """Return what mends a time that repeats: rows that are there twice, or stamps too coarse for the rows."""
    share, twice = float(np.mean(step == 0.0)), _again(columns)
    if twice or share < TICKS:
        return 'import with [time] repeated = "last"' + (" (rows of one time are the same)" if twice else "")
    return f"state the rate (time_s = {{ rate_hz = ... }}): the stamps are coarser than the rows, and one row a stamp would leave {100 * (1.0 - share):.0f} %"

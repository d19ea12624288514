"""What mends a clock that does not rise: which rows may go, and which must not be sorted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.packets import packets_of
from sstl_cli.core.sound import TENSIONS

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


def gaps_of(columns: dict[str, Array], step: Array, period: float) -> tuple[str, str, str]:
    """Return what the gaps of a clock are, how long, and what mends them: rows are missing, or came in packets and were stamped on arrival."""
    tensions = tuple(columns[c] for c in TENSIONS if c in columns)
    packets = packets_of(columns["time_s"], tensions) if len(step) + 1 == len(columns["time_s"]) else None
    if packets is not None:
        return "stamped in packets", packets.said, packets.mend
    return "gaps", f"longest {step.max():.4g} s at a period of {period:.4g} s", "split the run at its gaps"

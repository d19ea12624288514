"""Clocks whose zero lies long before a recording, known by their values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# unix times of the years 2001 to 2100, by the unit they are counted in
EPOCHS = ((1e9, "s"), (1e12, "ms"), (1e15, "us"), (1e18, "ns"))
EPOCH_LAST = 4.1
# the same years in steps of 100 ns since the year 1 (.NET) and 1601 (Windows)
HUNDRED_NS = ((6.31e17, 6.63e17), (1.26e17, 1.58e17))
# days since 1900 or of the year 0, as spreadsheets and MATLAB count them
DAYS = ((36_000.0, 73_000.0), (730_000.0, 770_000.0))


def of_days(values: Array) -> bool:
    """Return whether values are days since 1900 or of the year 0."""
    return any(a <= values[0] < b for a, b in DAYS)


def hundred_ns(values: Array) -> bool:
    """Return whether values are times in steps of 100 ns."""
    return any(a <= values[0] < b for a, b in HUNDRED_NS)


def epoch(values: Array) -> str:
    """Return the unit of values that are unix times, '' where they are none."""
    return next((unit for start, unit in EPOCHS if start <= values[0] < EPOCH_LAST * start), "")


def is_epoch(values: Array) -> bool:
    """Return whether a clock is unix time, ticks of .NET, or days since 1900, by its values: it begins long before the recording."""
    return bool(epoch(values)) or hundred_ns(values) or of_days(values)

"""Runs too short for anything to be wrong with but that: told in a few microseconds, as a log may hold a million of them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.sound import FASTEST_S, LARGEST, REQUIRED, SMALLEST, TENSIONS

Array = NDArray[np.float64]


def plain(columns: Mapping[str, Array], nulls: Mapping[str, int]) -> bool:
    """Return whether the few samples of a run are in order at first sight: an even clock, tensions that sensors can have read, and
    no other channel.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (n,)
        Time (s), tensions (N) and further channels; ``nulls`` counts the values of each that are empty.
    """
    for name, values in columns.items():
        if name not in REQUIRED:
            if nulls.get(name, 0) != len(values):
                return False
            continue
        # lists of a few numbers are quicker than arrays; what is no number makes the sum none
        told = values.tolist()
        if nulls.get(name, 0) or not told or not math.isfinite(sum(told)):
            return False
        low, high = min(told), max(told)
        if low < -LARGEST or high > LARGEST or (name in TENSIONS and 0.0 < max(-low, high) < SMALLEST):
            return False
        if name == "time_s":
            steps = [b - a for a, b in zip(told[:-1], told[1:], strict=True)]
            if steps and not FASTEST_S <= min(steps) == max(steps):
                return False
    return all(name in columns for name in REQUIRED)

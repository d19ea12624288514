"""Readings that were missing and filled with one number: a channel jumps to the same level again and again, and back to where it was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import quantile

Array = NDArray[np.float64]
MEND = '[repair] dropouts = "interpolate" (with these samples empty), or spikes = "interpolate"'
# part of the span, and usual steps, that a jump must make; longest stretch filled (samples), and how near to where it was the channel comes back
JUMP, BEYOND, LONGEST, BACK = 0.1, 12.0, 200, 0.5
# least number of stretches at one level, and part of all stretches that are at it
FEWEST, SAME = 3, 0.8


@dataclass(frozen=True)
class Dropouts:
    """Samples that read one level (N) between others far from it, in how many stretches, and the first of these (index)."""

    level_n: float
    samples: int
    stretches: int
    first: int


def dropouts_of(v: Array, other: Array) -> Dropouts | None:
    """Return the level at which a channel drops out, None where it does not, or where the other one jumps with it."""
    step = np.diff(v)
    low, high = quantile(v, 0.02), quantile(v, 0.98)
    least = max(JUMP * (high - low), BEYOND * quantile(np.abs(step), 0.75))
    if least <= 0.0:
        return None
    at = np.flatnonzero(np.abs(step) > least)
    if not 2 * FEWEST <= len(at) <= len(v) // 3:
        return None
    found: list[tuple[int, int]] = []
    for k, m in zip(at[:-1].tolist(), at[1:].tolist(), strict=True):
        flat = np.all(v[k + 1 : m + 1] == v[k + 1])
        if m - k <= LONGEST and flat and step[k] * step[m] < 0.0 and abs(v[m + 1] - v[k]) < BACK * abs(step[k]):
            found.append((k, m))
    if len(found) < FEWEST:
        return None
    levels, counts = np.unique([v[k + 1] for k, _ in found], return_counts=True)
    level, many = float(levels[np.argmax(counts)]), int(counts.max())
    mine = [(k, m) for k, m in found if v[k + 1] == level]
    # a movement in steps has its jumps in both channels
    together = float(np.median([abs(other[k + 1] - other[k]) for k, _ in mine])) > JUMP * float(np.ptp(other))
    # an overflow goes on from the other end; a flag has but two levels
    two = len(np.unique(v)) < 2 * FEWEST
    if many < FEWEST or many < SAME * len(found) or many < SAME * 0.5 * len(at) or together or two:
        return None
    return Dropouts(level, sum(m - k for k, m in mine), many, mine[0][0] + 1)

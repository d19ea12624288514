"""Readings that were missing, filled with one number or of a connector that let go: a channel jumps to the same level again and again, and back to where it was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median, noise_sd, quantile

Array = NDArray[np.float64]
MEND = '[repair] dropouts = "interpolate" (with these samples empty), or spikes = "interpolate"'
# part of the span, and usual steps, that a jump must make; longest stretch filled (samples), and how near to where it was the channel comes back
JUMP, BEYOND, LONGEST, BACK = 0.1, 12.0, 200, 0.5
# least number of stretches at one level, and part of all stretches that are at it
FEWEST, SAME = 3, 0.8
# noises of the channel within which the readings of a stretch lie, and its middle from that of the others: an amplifier without its sensor has some
FLAT, LEVEL = 8.0, 4.0


@dataclass(frozen=True)
class Dropouts:
    """Samples that read one level (N) between others far from it, in how many stretches, the first of these (index), and whether they are one number."""

    level_n: float
    samples: int
    stretches: int
    first: int
    filled: bool


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
    noise = noise_sd(v)
    found: dict[bool, list[tuple[int, int]]] = {True: [], False: []}
    for k, m in zip(at[:-1].tolist(), at[1:].tolist(), strict=True):
        near = m - k <= LONGEST and step[k] * step[m] < 0.0 and abs(v[m + 1] - v[k]) < BACK * abs(step[k])
        if near and float(np.ptp(v[k + 1 : m + 1])) <= FLAT * noise:
            # between two dropouts a channel may rest as well, on the other side of the jumps
            found[bool(step[k] > 0.0)].append((k, m))
    level, mine = max((_at_one_level(v, ends, LEVEL * noise) for ends in found.values()), key=lambda side: len(side[1]))
    many = len(mine)
    if many < max(FEWEST, SAME * 0.5 * len(at)):
        return None
    # a movement in steps has its jumps in both channels
    together = float(np.median([abs(other[k + 1] - other[k]) for k, _ in mine])) > JUMP * float(np.ptp(other))
    # an overflow goes on from the other end; a flag has but two levels
    two = len(np.unique(v)) < 2 * FEWEST
    if together or two:
        return None
    filled = len({float(own) for k, m in mine for own in v[k + 1 : m + 1]}) == 1
    return Dropouts(level, sum(m - k for k, m in mine), many, mine[0][0] + 1, filled)


def _at_one_level(v: Array, found: list[tuple[int, int]], within: float) -> tuple[float, list[tuple[int, int]]]:
    """Return the level (N) of stretches between two jumps, and those that are at it: none, where too many are elsewhere."""
    levels = np.array([median(v[k + 1 : m + 1]) for k, m in found])
    level = median(levels) if found else 0.0
    mine = [ends for ends, own in zip(found, levels, strict=True) if abs(own - level) <= within]
    return level, mine if len(mine) >= SAME * len(found) else []

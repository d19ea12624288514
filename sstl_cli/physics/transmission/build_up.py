"""Friction that builds up ever more slowly on its way to the limit: Dahl's law and its kin."""

from __future__ import annotations

import math

from numba import njit

# what is missing of the limit, as a part of it, that is nothing
NOTHING_MISSING = 1e-12


@njit(cache=True, error_model="numpy", nogil=True)
def built_up(
    way: float, towards: int, force_old: float, low: float, high: float, pull: float, release: float, tail: float
) -> tuple[float, float, float]:
    """Return the friction (N) after a way (in break-away distances), and its slopes over the way (N) and over the tension before.

    What is missing to the limit, g = 1 - F/L, falls as dg/dx = -(1 - s) g^(1/2) - s g with the tail s: Dahl's law
    (TOR-158(3107-18), 1968) with its exponent 1, one that ends after two break-away distances, or between them. Its root obeys a
    linear equation.
    """
    kept, keeps = force_old, 0.0
    # the limits follow the tension: what is beyond them has slipped
    if kept > high:
        kept, keeps = high, pull
    elif kept < low:
        kept, keeps = low, -release
    if way == 0.0:
        # at rest the next way is that of the last step; where either may be, the steeper one is not too far
        up, down = 0.0, 0.0
        if high > 0.0 and towards >= 0:
            up = high * _steepness(max(1.0 - kept / high, 0.0), tail)
        if low < 0.0 and towards <= 0:
            down = -low * _steepness(max(1.0 - kept / low, 0.0), tail)
        return kept, max(up, down), keeps
    limit, follows = (high, pull) if way > 0.0 else (low, -release)
    missing = 1.0 - kept / limit if limit != 0.0 else 0.0
    if missing <= NOTHING_MISSING:
        return limit, 0.0, follows
    root, half = math.sqrt(missing), 0.5 * abs(way)
    if tail > 0.0:
        end = (1.0 - tail) / tail
        root = (root + end) * math.exp(-tail * half) - end
    else:
        root -= half
    left = max(root, 0.0) ** 2
    slope = _steepness(left, tail)
    remembers = slope / _steepness(missing, tail)
    return limit * (1.0 - left), abs(limit) * slope, follows * (1.0 - left - (1.0 - missing) * remembers) + keeps * remembers


@njit(cache=True, error_model="numpy", nogil=True)
def _steepness(missing: float, tail: float) -> float:
    """Return how fast friction builds up of which a part is missing, over that of the beginning."""
    return (1.0 - tail) * math.sqrt(missing) + tail * missing

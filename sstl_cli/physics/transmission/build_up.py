"""Friction that builds up ever more slowly on its way to the limit: Dahl's law and its kin."""

from __future__ import annotations

from typing import Any

from numba import njit

from sstl_cli.physics.transmission.lanes import exp, larger, root, select, size, some, wide

# what is missing of the limit, as a part of it, that is nothing
NOTHING_MISSING = 1e-12


@njit(error_model="numpy", inline="always")
def built_up(way: Any, towards: Any, force_old: Any, low: Any, high: Any, pull: Any, release: Any, tail: Any) -> tuple[Any, Any, Any]:
    """Return the friction (N) after a way (in break-away distances), and its slopes over the way (N) and over the tension before.

    What is missing to the limit, g = 1 - F/L, falls as dg/dx = -(1 - s) g^(1/2) - s g with the tail s: Dahl's law
    (TOR-158(3107-18), 1968) with its exponent 1, one that ends after two break-away distances, or between them. Its root obeys a
    linear equation. All are vectors (see lanes); ``towards`` has the sign of the way before.
    """
    over, under = force_old > high, force_old < low
    # the limits follow the tension: what is beyond them has slipped
    kept = select(over, high, select(under, low, force_old))
    keeps = select(over, pull, select(under, -release, 0.0))
    ahead = way > 0.0
    limit, follows = select(ahead, high, low), select(ahead, pull, -release)
    missing = select(limit != 0.0, 1.0 - kept / limit, 0.0)
    rest = way == 0.0
    there = (missing <= NOTHING_MISSING) & ~rest
    missing = larger(missing, wide(NOTHING_MISSING))
    whole, half = root(missing), 0.5 * size(way)
    end = (1.0 - tail) / tail
    short = select(tail > 0.0, (whole + end) * exp(-tail * half) - end, whole - half)
    short = larger(short, wide(0.0))
    left = short * short
    slope = (1.0 - tail) * short + tail * left
    remembers = slope / ((1.0 - tail) * whole + tail * missing)
    force, stays = limit * (1.0 - left), size(limit) * slope
    follow = follows * (1.0 - left - (1.0 - missing) * remembers) + keeps * remembers
    if some(rest):
        # at rest the next way is that of the last step; where either may be, the steeper one is not too far
        up = select((high > 0.0) & (towards >= 0.0), high * _steepness(1.0 - kept / high, tail), 0.0)
        down = select((low < 0.0) & (towards <= 0.0), -low * _steepness(1.0 - kept / low, tail), 0.0)
        force, stays, follow = select(rest, kept, force), select(rest, larger(up, down), stays), select(rest, keeps, follow)
    return select(there, limit, force), select(there, 0.0, stays), select(there, follows, follow)


@njit(error_model="numpy", inline="always")
def _steepness(missing: Any, tail: Any) -> Any:
    """Return how fast friction builds up of which a part is missing, over that of the beginning."""
    missing = larger(missing, wide(0.0))
    return (1.0 - tail) * root(missing) + tail * missing

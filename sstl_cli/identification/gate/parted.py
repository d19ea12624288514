"""Friction of another size from one sample on: two bends in one run, joined where both channels read the same.

No channel jumps there. What tells it is that friction which changes at one sample explains the run, and friction of one size with any slip,
friction by speed, a zero that creeps and friction that runs in or warms up do not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.causes import MORE, SPEED, SPEEDS_OVER, Cause, Causes, best_fit, bundled, by_speed, finest, floor_of
from sstl_cli.identification.gate.movement import WAY, ways_of

Array = NDArray[np.float64]
# points of the search, samples (parts of the run) at which it begins, and how many of the best of these are followed
POINTS, CUTS, FOLLOWED = 384, 11, 3
# part of the run on either side: what settles does so at its beginning
SIDE = 0.12
# paths and times over which friction runs in (parts of those of the run)
RUNS_IN = (0.03, 0.1, 0.3, 1.0)
# what is left may be of what anything else leaves: of sound runs, with effects of all kinds, four fifths at the least
TAKES = 0.6
# least part of the output's span that one friction must leave: another n theta by a twelfth moves a half of the run by 2 to 5 % of its tension
LEAST = 0.01
# difference of the logarithms of n theta from which on two bends are two: friction that runs in, or falls with speed, turns by a tenth where a movement does
APART = 0.15


@dataclass(frozen=True)
class Parted:
    """When friction becomes another one (s), and n theta before and after."""

    at_s: float
    wraps: tuple[float, float]


def parted_of(points: tuple[Array, Array, Array], noise_n: float, rest_n: float, causes: Causes) -> Parted | None:
    """Return where friction becomes another one, None where anything else leaves as little.

    Parameters
    ----------
    points : tuple of ndarray, shape (n,)
        Time in s, input and output in N.
    noise_n : float
        White noise of the output (N).
    rest_n : float
        What friction, alone and with any slip, leaves (N RMS).
    causes : Causes
        The noise of both sensors as the output shows it.
    """
    t, x, y = points
    floor = floor_of(noise_n, y)
    if rest_n < max(MORE * causes.noise_n, LEAST * float(np.ptp(y))):
        return None
    at = _likeliest(x, y, floor)
    if max(map(min, ways_of(y[:at], noise_n), ways_of(y[at:], noise_n))) < WAY:
        # of a pull here and a release there each may have its own friction in one bend, and what breaks away has another one
        return None
    found = _fit(x, y, _step(len(x), at), floor)
    if not causes.left(found.rms_n) < TAKES * causes.left(rest_n):
        return None
    # friction that fades over a path without end has no size before that path was gone: what bends there is its law
    if causes.left(causes.fading.rms_n) < causes.left(causes.friction.rms_n) and not causes.noise_alone(found.rms_n):
        return None
    path = np.cumsum(np.abs(np.diff(x, prepend=x[0])))
    gradual = [np.exp(-way / (part * way[-1])) for way in (path, t - t[0]) for part in RUNS_IN]
    wraps = (found.wrap, found.wrap * (1.0 + found.size))
    if not all(_slides(x[side], wrap) for side, wrap in zip((slice(None, at), slice(at, None)), wraps, strict=True)):
        return None
    if min(wraps) <= 0.0 or abs(math.log(wraps[1] / wraps[0])) < APART:
        return None
    others = [*(_fit(x, y, part, floor) for part in gradual), by_speed(t, x, y, floor, None, SPEEDS_OVER)]
    if not causes.left(found.rms_n) < TAKES * min(causes.left(c.rms_n) for c in others):
        return None
    return Parted(float(t[at]), wraps)


def _slides(x: Array, wrap: float) -> bool:
    """Whether an input goes farther than half of the backlash of this friction: begun between the lines it reaches one of them."""
    low, high = float(np.min(x)), float(np.max(x))
    return low <= 0.0 or math.log(high / low) > wrap


def _likeliest(x: Array, y: Array, floor: float) -> int:
    """Return the sample from which on another friction leaves least, by halving steps about the best of a few."""
    m = max(1, len(x) // POINTS)
    few, its = np.ascontiguousarray(x[::m]), np.ascontiguousarray(y[::m])
    n = len(few)
    least, most = int(SIDE * n), int((1.0 - SIDE) * n)

    @cache
    def fit(k: int) -> Cause:
        return _fit(few, its, _step(n, k), floor)

    begun = sorted((int(k) for k in np.linspace(least, most, CUTS)), key=lambda k: fit(k).rms_n)
    found = [finest(fit, k, (most - least) // CUTS, range(least, most + 1)) for k in begun[:FOLLOWED]]
    return m * min(found, key=lambda c: c[0].rms_n)[1]


def _fit(x: Array, y: Array, part: Array, floor: float) -> Cause:
    """Return the best fit of friction that is more by a share (the ``size``) of ``part`` (0 to 1), shape (n,)."""
    return best_fit(x, y, bundled(SPEED), floor, speed=part)


def _step(n: int, k: int) -> Array:
    return (np.arange(n) >= k).astype(np.float64)

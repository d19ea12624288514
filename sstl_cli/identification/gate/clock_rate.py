"""Another rate of the output's clock: rows of two loggers put side by side, whatever rate each of them had."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.causes import FRICTION, Causes, best_fit, bundled, floor_of

Array = NDArray[np.float64]
# rates of two loggers that stand side by side: multiples of the one by the other
RATES = (0.5, 2.0, 0.2, 5.0, 0.1, 10.0, 0.25, 4.0, 0.4, 2.5)
# what must be left (share of the output's span) for other rates to be tried
NOTHING = 0.12
# what friction at another rate may leave of what all else leaves, and of the output's span
LEAVES, LITTLE = 0.2, 0.03
# points that a part of a run must have, and part of the whole output's span that it must go
LEAST_POINTS, MOVES = 100, 0.3


@dataclass(frozen=True)
class ClockRate:
    """How many times as fast as the input's the output's clock runs, and what friction then leaves of the output (N RMS)."""

    rate: float
    rms_n: float


def clock_rate_of(t: Array, x: Array, y: Array, duration_s: float, noise_n: float, causes: Causes) -> ClockRate | None:
    """Return the rate at which friction explains an output that nothing else does, None where there is none.

    Parameters
    ----------
    t, x, y : ndarray, shape (n,)
        Time in s from the first sample, input and output in N.
    duration_s : float
        Duration of the run.
    noise_n : float
        White noise of the output (N).
    causes : Causes
        What friction leaves, alone and with one slip.
    """
    span = float(np.ptp(y))
    least = causes.least_n(duration_s)
    if not least > NOTHING * span > 0.0:
        return None
    found = [r for rate in RATES if (r := _at(rate, t, x, y, floor_of(noise_n, y))) is not None]
    best = min(found, key=lambda r: r.rms_n, default=None)
    if best is None or not best.rms_n < min(LITTLE * span, LEAVES * least):
        return None
    return best


def _at(rate: float, t: Array, x: Array, y: Array, floor: float) -> ClockRate | None:
    """Return what friction leaves of the part of an output whose input was recorded, if the output's clock runs at a rate."""
    inside = rate * t <= t[-1]
    if np.count_nonzero(inside) < LEAST_POINTS or float(np.ptp(y[inside])) < MOVES * float(np.ptp(y)):
        return None
    moved = np.interp(rate * t[inside], t, x)
    rms = best_fit(moved, np.ascontiguousarray(y[inside]), bundled(FRICTION), floor).rms_n
    return ClockRate(rate, rms) if math.isfinite(rms) else None

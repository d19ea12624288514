"""A clock that reads late or early without saying so: readings are off by as much as the tension moves meanwhile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from sstl_cli.diagnosis.constants import DOUBT_NATS, ENOUGH_HELD, RATE_GROUPS, STEADY
from sstl_cli.diagnosis.recorder import quiet

Array = NDArray[np.float64]
# of a logarithm, whose exponential times any square is still a number
LARGEST = 0.5 * float(np.log(np.finfo(float).max))


@dataclass(frozen=True)
class Piece:
    """What the smoothed input leaves of the readings of one sensor (N), and how fast the tension moves there (N/s), both of shape (n,)."""

    sensor: str
    left_n: Array
    rate: Array
    dt_s: float


def unstamped(pieces: Sequence[Piece]) -> float:
    """Return the standard deviation (s) by which instants of readings are off the even clock of their log, 0 where none shows.

    The variance of readings about a smooth input is that of the sensor, and the square of jitter times rate. It is taken in groups
    of equal rate, without the loudest twentieth, and both are the most likely ones; jitter is believed at the odds that are asked
    of anything that is new.
    """
    variances, squares, counts, whose = [], [], [], []
    sensors = sorted({p.sensor for p in pieces})
    for k, sensor in enumerate(sensors):
        left = np.concatenate([p.left_n for p in pieces if p.sensor == sensor])
        rate = np.abs(np.concatenate([p.rate for p in pieces if p.sensor == sensor]))
        if len(left) < ENOUGH_HELD:
            continue
        for part in np.array_split(np.argsort(rate), RATE_GROUPS):
            variances.append(quiet(np.abs(left[part])) ** 2)
            squares.append(float(np.mean(rate[part] ** 2)))
            counts.append(len(part))
            whose.append(k)
    v, square, n, own = np.array(variances), np.array(squares), np.array(counts, np.float64), np.array(whose, np.intp)
    if not len(v) or not np.all(v > 0.0):
        return 0.0

    def cost(p: Array) -> float:
        # a search may ask for the absurd; it must only stay a number
        log = np.minimum(p, LARGEST)
        expected = np.exp(log[own]) + np.exp(log[-1]) * square
        return 0.5 * float(np.sum(n * (np.log(expected) + v / expected)))

    white = np.array([np.log(np.min(v[own == k], initial=np.inf)) if np.any(own == k) else 0.0 for k in range(len(sensors))])
    longest = STEADY * max(p.dt_s for p in pieces)
    even = minimize(lambda p: cost(np.append(p, -np.inf)), white, method="BFGS")
    tried = minimize(cost, np.append(white, 2.0 * np.log(0.5 * longest)), method="BFGS")
    jitter = float(np.exp(0.5 * tried.x[-1]))
    return min(jitter, longest) if even.fun - tried.fun > DOUBT_NATS else 0.0

"""A sensor that is lost for a part of a run: it shows its noise about a constant while the other one goes where no friction would let it rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median, quantile
from sstl_cli.identification.gate.rests import stretches

Array = NDArray[np.float64]
# spreads of the noise within which a channel that rests stays
NOISE = 7.0
# least part of a run, time (s) and points that a sensor is lost for, and part of them that may repeat a value: without noise that is another fault
LEAST_SHARE, LEAST_S, LEAST_POINTS, REPEATS = 0.05, 0.5, 12, 0.5
# noises and usual steps that a channel jumps by when it is lost or comes back
OFF, STEPS = 10.0, 4.0


@dataclass(frozen=True)
class Lost:
    """The stretch in which a channel rests furthest below the other one: when and how long (s), at what level, and how far the other one then goes (N)."""

    at_s: float
    length_s: float
    level_n: float
    reached_n: float


def lost_of(t: Array, v: Array, other: Array, noise_n: float) -> Lost | None:
    """Return where a channel rests though the other one goes furthest beyond it, None where it never rests so long.

    Parameters
    ----------
    t, v, other : ndarray, shape (n,)
        Time in s, the channel and the other one in N, samples or means of a few.
    noise_n : float
        White noise of a sample of the channel (N).
    """
    n, period = len(v), float(t[-1] - t[0]) / (len(v) - 1)
    least = max(int(LEAST_SHARE * n), int(LEAST_S / period), LEAST_POINTS)
    found = [
        Lost(float(t[a]), (b - a) * period, median(v[a:b]), quantile(other[a:b], 0.995))
        for a, b in stretches(v, NOISE * noise_n, least)
        if float(np.mean(np.diff(v[a:b]) == 0.0)) < REPEATS and _cut_off(v, a, b, noise_n)
    ]
    return max(found, key=lambda f: f.reached_n / max(abs(f.level_n), noise_n, 1e-300), default=None)


def _cut_off(v: Array, a: int, b: int, noise_n: float) -> bool:
    """Whether a rest begins and ends at once, or with the run: a connection is lost from one sample to the next, a tension comes and goes by a way."""
    level, usual = median(v[a:b]), OFF * noise_n + STEPS * quantile(np.abs(np.diff(v)), 0.98)
    # the means of some samples may have one on the way
    before, after = v[max(0, a - 2) : a], v[b : b + 2]
    return all(not len(side) or float(np.max(np.abs(side - level))) > usual for side in (before, after))

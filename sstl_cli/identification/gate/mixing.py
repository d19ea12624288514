"""A part of the input in the output: the noise of both tells how much, and friction whether the output without it is one.

Movement that passes through the sheath carries the noise of the drive with it as well; but what remains of a sound output once a part of its input is taken
off is explained by no friction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median
from sstl_cli.identification.gate.causes import GAIN, Causes, best_fit, bundled, by_speed, floor_of
from sstl_cli.identification.gate.fading import fading_of
from sstl_cli.identification.gate.sensors import Sensor

Array = NDArray[np.float64]
# correlation of the noises, and its standard errors, from which on a part is asked about; quiet differences (medians) that tell it, and fewest of them
SHARED, ERRORS, QUIET, FEWEST = 0.15, 5.0, 8.0, 100
# sensors feel one another's tension by a twentieth at the most
LEAST = 0.15
# standard errors about what the noise tells within which friction may choose the part
WITHIN = (-2.0, -1.0, 0.0, 1.0, 2.0)


@dataclass(frozen=True)
class Mixed:
    """The part of the input that an output holds by its noise, the error of that, and of the output beside it the gain, n theta, and what friction leaves (N RMS)."""

    share: float
    error: float
    gain: float
    wrap: float
    rms_n: float


def mixed_of(raw: tuple[Array, Array], points: tuple[Array, Array, Array], sensors: tuple[Sensor, Sensor], causes: Causes) -> Mixed | None:
    """Return the part of the input that the output holds, None where their noises have nothing in common.

    Parameters
    ----------
    raw : tuple of ndarray
        All readings of input and output (N).
    points : tuple of ndarray, shape (n,)
        Time in s, input and output in N that friction is fitted to.
    """
    found = _shared(*raw) if sensors[0].fine and not sensors[0].held else None
    if found is None:
        return None
    share, error = found
    if causes.enough:
        return Mixed(share, error, math.nan, math.nan, math.inf)
    (t, x, y), floor = points, floor_of(sensors[1].noise_n, points[2])
    # of a mean the parts make one, of a sum or difference the output is whole
    scales = [scale for scale in (1.0, 1.0 - share) if scale > 0.0]
    rests = [y - (share + k * error) * x for k in WITHIN]
    fits = [(_beside(x, rest, scales, floor), rest) for rest in rests]
    best, rest = min(fits, key=lambda f: f[0][2])
    sign = math.copysign(1.0, best[0])
    drags = [(sign * scale, by_speed(t, x, sign * rest / scale, floor, None)) for scale in scales]
    return Mixed(share, error, *min(best, *((g, d.wrap, abs(g) * d.rms_n) for g, d in drags), key=lambda f: f[2]))


def _shared(x: Array, y: Array) -> tuple[float, float] | None:
    """Return the part of one channel's noise that is in the other one, and its standard error."""
    a, b = np.diff(x, 2), np.diff(y, 2)
    quiet = (np.abs(a) < QUIET * median(np.abs(a))) & (np.abs(b) < QUIET * median(np.abs(b)))
    a, b = a[quiet], b[quiet]
    n, power = len(a), (float(a @ a), float(b @ b))
    if n < FEWEST or min(power) <= 0.0:
        return None
    correlation = float(a @ b) / math.sqrt(power[0] * power[1])
    # neighbouring second differences of white noise share two of three readings
    error = 1.5 / math.sqrt(n)
    scale = math.sqrt(power[1] / power[0])
    shown = abs(correlation) > max(SHARED, ERRORS * error) and abs(correlation) * scale > LEAST
    return (correlation * scale, error * scale * math.sqrt(max(1.0 - correlation**2, 0.0))) if shown else None


def _beside(x: Array, rest: Array, scales: list[float], floor: float) -> tuple[float, float, float]:
    """Return the gain and n theta with which friction explains what is left of an output, and what it leaves (N RMS)."""
    sign = 1.0 if float(np.median(rest)) >= 0.0 else -1.0
    found = best_fit(x, sign * rest, bundled(GAIN), floor)
    fits = [(sign * math.exp(found.size), found.wrap, found.rms_n)]
    for scale in scales:
        wrap, rms = fading_of(x, sign * rest / scale)
        fits.append((sign * scale, wrap, scale * rms if math.isfinite(rms) else math.inf))
    return min(fits, key=lambda f: f[2])

"""Whether two channels share their noise, and whether that of one changes within a run."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median, noise_sd
from sstl_cli.identification.gate.live import noisy
from sstl_cli.identification.gate.sensors import Sensor

Array = NDArray[np.float64]
# samples in which shared noise shows
ENOUGH = 1536


def line_share(t: Array, v: Array) -> float:
    """Return how much of a channel's variance a straight line in time explains."""
    return float(np.corrcoef(t, v)[0, 1] ** 2) if float(np.std(v)) > 0.0 else math.nan


def noise_correlation(x: Array, y: Array) -> float:
    """Return the correlation of second differences: sensors of their own share no noise."""
    a, b = np.diff(x[:ENOUGH], 2), np.diff(y[:ENOUGH], 2)
    limit_a, limit_b = (8.0 * median(np.abs(v)) for v in (a, b))
    if limit_a == 0.0 or limit_b == 0.0:
        return math.nan
    quiet = (np.abs(a) < limit_a) & (np.abs(b) < limit_b)
    a, b = a[quiet], b[quiet]
    return float(a @ b / math.sqrt(float(a @ a) * float(b @ b))) if len(a) > 16 else math.nan


def noise_ratio(first: Array, second: Array, sensor: Sensor) -> float:
    """Return the noise of the second half over that of the first, NaN where a channel shows none of its own."""
    if sensor.held or sensor.step_n > 0.5 * sensor.noise_n or not (noisy(first) and noisy(second)):
        return math.nan
    return noise_sd(second) / max(noise_sd(first), 1e-300)

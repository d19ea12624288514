"""Sensor noise: white, and coloured with an exponential autocorrelation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NoiseModel:
    """Standard deviations (N) of white and coloured noise, and the correlation time (s) of the latter."""

    white_n: float = 0.02
    coloured_n: float = 0.0
    correlation_s: float = 0.3


def sensor_noise(model: NoiseModel, n: int, dt_s: float, rng: np.random.Generator) -> Array:
    """Return a stationary sample of sensor noise in N, shape (n,)."""
    noise = model.white_n * rng.standard_normal(n)
    if model.coloured_n > 0.0:
        phi = float(np.exp(-dt_s / model.correlation_s))
        drive = rng.standard_normal(n) * np.sqrt(1.0 - phi**2)
        drive[0] = rng.standard_normal()
        noise = noise + model.coloured_n * lfilter([1.0], [1.0, -phi], drive)
    return noise

"""What is left of a record once the lines of single frequencies are taken out of it: mains hum is the same in all runs, noise is not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.hum import around, window_of

Array = NDArray[np.float64]
# power of a line over the mean of what is around it: noise goes so far in one record of a million
STANDS_OUT = 20.0
# a mains has so many harmonics, or aliases of them, that are worth a line each
LINES = 8


def without_lines(v: Array) -> Array:
    """Return a record less every sinusoid that stands out of its spectrum, shape (n,)."""
    for _ in range(LINES):
        power = _power(v)
        k = int(np.argmax(power))
        beside = around(power, k)
        if not len(beside) or not power[k] > STANDS_OUT * float(np.mean(beside)):
            break
        v = _without(v, k)
    return v


def without_strongest(v: Array) -> Array:
    """Return a record less its strongest sinusoid, shape (n,)."""
    return _without(v, int(np.argmax(_power(v))))


def _power(v: Array) -> Array:
    return np.asarray(np.abs(np.fft.rfft(window_of(len(v)) * v)) ** 2)


def _without(v: Array, k: int) -> Array:
    """Return a record less the line at a bin, whose size may go along: so does that of a frequency between two bins, which turns against this one."""
    at, turn = np.linspace(-1.0, 1.0, len(v)), 2.0 * np.pi * k / len(v) * np.arange(len(v))
    basis = np.stack([at**power * wave for power in range(3) for wave in (np.cos(turn), np.sin(turn))], axis=1)
    return np.asarray(v - basis @ np.linalg.lstsq(basis, v, rcond=1e-9)[0])

"""Readings hit by a pulse that a filter of the amplifier lets decay: off the line from one reading to the next, back by a fixed share each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import AT_MOST, BESIDE_PULSE, DOUBT_NATS, LONGEST_PULSE, SPIKE_SIGMA

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def pulses(signal: Array, noise: float) -> Mask:
    """Return the readings that a decaying pulse has hit, shape (n,).

    A line that slips jumps as fast but does not come back; what comes back over several readings without having gone in one is a movement.

    Parameters
    ----------
    signal : ndarray, shape (n,)
        Readings (N).
    noise : float
        Standard deviation of their white noise (N).
    """
    hit = np.zeros(len(signal), np.bool_)
    for at in np.flatnonzero(_jumps(signal, noise)) + 1:
        length = 0 if hit[at] else _length(signal, int(at), noise)
        hit[at : at + length] = True
    return hit


def _jumps(signal: Array, noise: float) -> Mask:
    """Return the steps that are larger than those around them by far more than noise, shape (n - 1,)."""
    step = np.abs(np.diff(signal))
    before = np.concatenate((step[:1], step[:-1]))
    return np.asarray(step > SPIKE_SIGMA * noise + np.minimum(before, np.concatenate((before[:1], before[:-1]))))


@dataclass(frozen=True)
class _Window:
    """Readings about a pulse of one length: where they are, which are hit, and what takes a parabola beside it, or one with a jump that stays, away."""

    where: Array
    inside: Mask
    beside: Array
    stays: Array


@cache
def _window(length: int) -> _Window:
    where = np.arange(-BESIDE_PULSE, length + BESIDE_PULSE, dtype=np.float64)
    inside = (where >= 0.0) & (where < length)
    line = np.column_stack((np.ones(len(where)), where / len(where), (where / len(where)) ** 2))
    away = np.eye(len(where))
    away[:, ~inside] -= line @ np.linalg.pinv(line[~inside])
    jump = np.column_stack((line, (where >= 0.0).astype(float)))
    return _Window(where, inside, away, np.eye(len(where)) - jump @ np.linalg.pinv(jump))


def _length(signal: Array, at: int, noise: float) -> int:
    """Return how many readings from one on a pulse has hit, 0 where none has or a jump that stays is not far less likely."""
    for length in range(2, LONGEST_PULSE + 1):
        begin, end = at - BESIDE_PULSE, at + length + BESIDE_PULSE
        if begin < 0 or end > len(signal):
            return 0
        w, part = _window(length), signal[begin:end] - signal[begin]
        off = w.beside @ part
        height, hit = off[w.inside][0], off[w.inside]
        # of one reading alone it is no pulse; it is gone behind its last one
        if abs(height) <= SPIKE_SIGMA * noise:
            continue
        kept = float(hit[1:] @ hit[:-1]) / max(float(hit[:-1] @ hit[:-1]), np.finfo(float).tiny)
        if kept * abs(height) <= AT_MOST * noise or kept**length * abs(height) > noise:
            continue
        left = np.where(w.inside, off - height * kept ** np.maximum(w.where, 0.0), off)
        otherwise = w.stays @ part
        nats = 0.5 * float(otherwise @ otherwise - left @ left) / noise**2
        if np.mean(left**2) <= AT_MOST * noise**2 and nats > DOUBT_NATS:
            return length
    return 0

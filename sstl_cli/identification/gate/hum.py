"""A sinusoid of one frequency in one channel, which no movement makes: mains hum, or what its sampling leaves of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# samples looked at, and fewest
MOST, FEWEST = 16_384, 256
# line over what is around it (power), bins of the line on either side, and bins around it
STANDS_OUT, WIDE, AROUND = 100.0, 3, 40
# least amplitude as a part of the span and of the largest value of both channels: less is what good rigs record
LEAST_SPAN, LEAST_LEVEL = 0.025, 0.01
# least frequency as a multiple of the movement's strongest: friction makes harmonics of it, smaller and smaller ones
ABOVE = 9.0
# a harmonic of a movement with corners or jumps is smaller than the movement's strongest over its order, but for what a window shows less of it
ORDER = 1.5
# amplitude in the other channel (in N, or shares of both spans) from which on it is a movement, and how alike it must be in all quarters of the run
SHARED, STEADY = 0.4, 0.5


@dataclass(frozen=True)
class Hum:
    """Amplitude (N) and frequency (Hz, or its alias below half the sampling rate) of a line."""

    amplitude_n: float
    frequency_hz: float


def hum_of(dt_s: float, v: Array, other: Array, drive: Array, stride: int = 1) -> Hum | None:
    """Return the line that stands in a channel and not in the other one, None where there is none.

    ``drive`` is the input, whose movement is that of both: an output within its backlash shows none of it. ``stride`` is the number of samples from one renewal of the slower channel to the next.
    """
    v, other, drive = v[::stride][:MOST], other[::stride][:MOST], drive[::stride][:MOST]
    n = len(v)
    span, reach = float(np.ptp(v)), float(np.ptp(other))
    if n < FEWEST or span <= 0.0:
        return None
    level, window = max(float(np.max(np.abs(c))) for c in (v, other)), window_of(n)
    mine, theirs, driven = (np.abs(np.fft.rfft(window * (c - np.mean(c)))) * 2.0 / float(window.sum()) for c in (v, other, drive))
    moves = 1 + int(np.argmax(driven[1:]))
    first = max(int(ABOVE * moves), AROUND)
    if first + AROUND >= len(mine):
        return None
    k = first + int(np.argmax(mine[first:-WIDE]))
    if mine[k] ** 2 < STANDS_OUT * float(np.mean(around(mine, k, 1) ** 2)) or mine[k] < max(LEAST_SPAN * span, LEAST_LEVEL * level):
        return None
    if reach > 0.0 and theirs[k - 1 : k + 2].max() > SHARED * mine[k] * min(1.0, reach / span):
        return None
    order = k / moves
    if abs(order - round(order)) * moves < WIDE and mine[k] < ORDER * driven[moves] / order:
        return None
    # of a line between two bins a window shows a little less
    quarters = [_amplitude(part, k / n, start) for start, part in _quarters(v)]
    steady = min(quarters) > STEADY * max(quarters)
    return Hum(float(np.median(quarters)), k / (n * stride * dt_s)) if steady else None


@lru_cache(maxsize=4)
def window_of(n: int) -> Array:
    """Return a Hann window: runs of one log are of few lengths."""
    return np.hanning(n)


def around(spectrum: Array, k: int, first: int = 0) -> Array:
    """Return what stands around a line at bin ``k`` of a spectrum, from its ``first`` bin on."""
    return np.concatenate((spectrum[max(first, k - AROUND) : max(first, k - WIDE)], spectrum[k + WIDE + 1 : k + AROUND]))


def _quarters(v: Array) -> list[tuple[int, Array]]:
    n = len(v) // 4
    return [(i * n, v[i * n : (i + 1) * n]) for i in range(4)]


def _amplitude(v: Array, cycles: float, start: int) -> float:
    """Return the amplitude of a line of ``cycles`` a sample."""
    window = np.hanning(len(v))
    turn = np.exp(-2j * np.pi * cycles * (start + np.arange(len(v))))
    return 2.0 * float(np.abs(np.sum(window * (v - np.mean(v)) * turn))) / float(window.sum())

"""Loops of a recording that is still growing: sample by sample, the same however the samples arrive.

A loop runs from one lower turn of the input to the next. A turn counts once the input has come back from it by
``SWING`` of the range seen so far, and by more than its noise; later samples never change an earlier turn.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

SWING = 0.3
OVER_NOISE = 12.0
TIE = 3.0
# the first samples tell the noise
WARM_UP = 16
# a spike or a short dropout turns nothing
HOLD_S = 0.04
# places of the state
COUNT, BACK1, BACK2, LOW, HIGH, ROUGH, DIRECTION, EXTREME, AT, BEYOND, HOLD = range(11)


class LoopCutter:
    """Finds the lower turns of one uninterrupted input signal."""

    def __init__(self) -> None:
        self._state = np.zeros(11)
        self._state[HOLD] = -1.0

    def add(self, input_n: Array, dt_s: float) -> list[int]:
        """Take further samples (N) and return the positions, from the first sample on, of the lower turns they confirm."""
        if self._state[HOLD] < 0.0:
            self._state[HOLD] = max(1.0, round(HOLD_S / dt_s)) if dt_s > 0.0 else 1.0
        return [int(i) for i in _advance(np.ascontiguousarray(input_n, np.float64), self._state)]

    @property
    def falling_to(self) -> int | None:
        """Position of the lowest sample of a release that is not over yet, None while pulling."""
        return int(self._state[AT]) if self._state[DIRECTION] < 0.0 else None


@njit(cache=True)
def _advance(x: Array, s: Array) -> list[int]:
    found = [0 for _ in range(0)]
    for k in range(x.size):
        n = int(s[COUNT])
        raw = x[k]
        a, b = (s[BACK1], s[BACK2]) if n > 1 else (raw, raw)
        # the middle of three: one sample far off is no turn
        v = max(min(a, b), min(max(a, b), raw))
        rough = abs(raw - 2.0 * a + b) if n > 1 else 0.0
        s[BACK2] = s[BACK1] if n > 0 else raw
        s[BACK1] = raw
        s[COUNT] = n + 1
        if n == 0:
            s[LOW], s[HIGH], s[EXTREME] = v, v, v
            continue
        # mean second difference of white noise is 1.954 sd; a jump counts like ten of the usual ones
        if n > WARM_UP:
            rough = min(rough, 10.0 * s[ROUGH] + 1e-12)
        s[ROUGH] += (rough - s[ROUGH]) / min(n, 4096)
        sd = s[ROUGH] / 1.954
        s[LOW], s[HIGH] = min(s[LOW], v), max(s[HIGH], v)
        swing = max(SWING * (s[HIGH] - s[LOW]), OVER_NOISE * sd, 1e-9)
        tie = min(TIE * sd, 0.25 * swing)
        at = n - 1 if n > 1 else n
        direction = s[DIRECTION]
        if direction == 0.0:
            # until the input has moved, every sample may be the lower turn the first loop begins with
            if v <= s[LOW] + tie:
                s[AT] = at
            if n > WARM_UP and v > s[LOW] + swing:
                s[BEYOND] = s[BEYOND] + 1.0 if s[BEYOND] > 0.0 else 1.0
            elif n > WARM_UP and v < s[HIGH] - swing:
                s[BEYOND] = s[BEYOND] - 1.0 if s[BEYOND] < 0.0 else -1.0
            else:
                s[BEYOND] = 0.0
            if s[BEYOND] >= s[HOLD]:
                found.append(int(s[AT]))
                s[DIRECTION], s[EXTREME], s[BEYOND] = 1.0, v, 0.0
            elif s[BEYOND] <= -s[HOLD]:
                s[DIRECTION], s[EXTREME], s[BEYOND], s[AT] = -1.0, v, 0.0, at
        elif direction > 0.0:
            s[EXTREME] = max(s[EXTREME], v)
            s[BEYOND] = s[BEYOND] + 1.0 if v < s[EXTREME] - swing else 0.0
            if s[BEYOND] >= s[HOLD]:
                s[DIRECTION], s[EXTREME], s[BEYOND], s[AT] = -1.0, v, 0.0, at
        else:
            s[EXTREME] = min(s[EXTREME], v)
            if v <= s[EXTREME] + tie:
                s[AT] = at
            s[BEYOND] = s[BEYOND] + 1.0 if v > s[EXTREME] + swing else 0.0
            if s[BEYOND] >= s[HOLD]:
                found.append(int(s[AT]))
                s[DIRECTION], s[EXTREME], s[BEYOND] = 1.0, v, 0.0
    return found


def usual_step(time_s: Array) -> float:
    """Return the usual sampling period (s) of the first samples, NaN for fewer than two."""
    steps = np.diff(time_s[:WARM_UP])
    return float(np.median(steps)) if len(steps) else math.nan

"""Whether the samples of a channel show a jump: beyond what it does on either side, and of one channel alone.

Points that are means of many samples share a jump between them, and a channel that is held goes on by steps; so jumps are
looked for in the renewed samples themselves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# steepest samples of each channel that are told
STEEPEST = 2
# part by which a jump may differ from the one that a change makes, samples on either side of it, and part that the other channel may jump by
ALIKE, BESIDE, OTHER = 0.35, 3, 0.5
# noises below which a jump between two lines is not seen: either is led on by two samples, where it is known to one and a half
NOISES = 8.0


@dataclass(frozen=True)
class Channel:
    """The samples ``at`` which a channel was renewed, and what it read there (N)."""

    at: NDArray[np.int64]
    values: Array

    def steepest(self) -> list[int]:
        """Return the samples to which it goes most."""
        return [int(k) for k in self.at[np.argsort(np.abs(np.diff(self.values)))[-STEEPEST:] + 1]]

    def unlikeliest(self) -> list[int]:
        """Return the samples to which it goes most beyond what it does before and after."""
        step = np.diff(self.values)
        if len(step) < 3:
            return []
        beyond = np.abs(step[1:-1] - 0.5 * (step[:-2] + step[2:]))
        return [int(k) for k in self.at[np.argsort(beyond)[-STEEPEST:] + 2]]


def channel_of(values: Array, held: bool = False) -> Channel:
    """Return a channel as its renewals, which are all of its samples unless it is ``held``."""
    at = np.flatnonzero(np.append(True, values[1:] != values[:-1])) if held else np.arange(len(values))
    return Channel(at, values[at])


def shown(
    channels: tuple[Channel, Channel], noise: tuple[float, float], near: range, channel: int, is_gain: bool, size: float
) -> bool | None:
    """Return whether a channel shows, ``near`` some samples, the jump of another gain (logarithm) or zero (N); None where it is too small to be seen.

    Parameters
    ----------
    channels : tuple of Channel
        Input and output.
    noise : tuple of float
        White noise of both (N).
    """
    own = channels[channel]
    first, last = np.searchsorted(own.at, [max(near.start, 1), near.stop])
    # the fit finds the sample to a few
    candidates = range(max(int(first), 1), int(last))
    if not candidates:
        return None
    j = max(candidates, key=lambda i: abs(float(own.values[i] - own.values[i - 1])))
    pairs = [_jump(c, int(own.at[j])) for c in channels]
    level = float(np.median(own.values[max(0, j - BESIDE) : j]))
    made = level * math.expm1(size) if is_gain else size
    usual = pairs[channel][1] + NOISES * noise[channel]
    if abs(made) < 2.0 * usual:
        return None
    spans = [max(float(np.ptp(c.values)), 1e-300) for c in channels]
    other = abs(pairs[1 - channel][0]) / spans[1 - channel] > OTHER * abs(made) / spans[channel]
    return abs(pairs[channel][0] - made) < ALIKE * abs(made) + usual and not other


def _jump(c: Channel, k: int) -> tuple[float, float]:
    """Return by how much the lines before and after a sample miss each other at its renewal, and what a corner there makes of that."""
    j = int(np.searchsorted(c.at, k))
    (before, rise), (after, fall) = _line(c.values[max(0, j - BESIDE) : j]), _line(c.values[j + 1 : j + 1 + BESIDE][::-1])
    # where a corner lies between two samples the lines miss each other by what their slopes differ
    return after - before, abs(rise + fall)


def _line(v: Array) -> tuple[float, float]:
    """Return where the line through some samples comes one sample later, and its slope by sample."""
    n = len(v)
    if n < 2:
        return float(v[-1]) if n else 0.0, 0.0
    slope = float(v[-1] - v[0]) / (n - 1)
    return float(np.mean(v)) + 0.5 * (n + 1) * slope, slope

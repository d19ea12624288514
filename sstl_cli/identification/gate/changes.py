"""A gain or a zero that changes within a run: friction on both sides of one sample, with one number more behind it.

All four changes (gain or zero, of the output or of the input) are fitted and compared with one another; the sample itself must show it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.causes import (
    FRICTION,
    GAIN_IN_FROM,
    GAIN_OUT_FROM,
    SPEEDS_OVER,
    ZERO_IN_FROM,
    ZERO_OUT_FROM,
    Behind,
    Cause,
    best_fit,
    bundled,
    by_speed,
    finest,
    floor_of,
)
from sstl_cli.identification.gate.jumps import ALIKE, BESIDE, Channel, channel_of, shown

Array = NDArray[np.float64]
# what is changed (channel: 0 input, 1 output; whether it is a gain), and the parameters that are free then
# whatever friction seems to be across a change, it may build up on either side of it
KINDS = {
    (1, True): bundled(GAIN_OUT_FROM),
    (0, True): bundled(GAIN_IN_FROM),
    (1, False): bundled(ZERO_OUT_FROM),
    (0, False): bundled(ZERO_IN_FROM),
}
# parts of the run tried beside the steepest samples of each channel, points of the first search, least points on either side
CUTS, COARSE_POINTS, LEAST_POINTS = 7, 384, 16
# what a change may leave of what any other slip leaves, and of the span: where the sample shows the jump, and where it is too small to be seen there
SHOWN, UNSEEN, LITTLE = 0.5, 0.2, 0.08
# what the first search must leave of it for a second
HOPEFUL = 0.8
# logarithms of a gain: least, and that of a sensor that goes dead; least zero (share of the channel's span)
LEAST_GAIN, MOST_GAIN, LEAST_ZERO = 0.2, 2.5, 0.03
# part of its span that an output must move by on either side: where it rests up to the end, its level there may have come of anything
MOVES = 0.1
# what a change may leave of what friction leaves that is another one on either side
FRICTION_TOO = 0.5


@dataclass(frozen=True)
class Change:
    """What changes (0 input, 1 output; gain or zero) ``at_s`` into the run, and the factor or the tension (N) by which."""

    channel: int
    is_gain: bool
    size: float
    at_s: float


@dataclass(frozen=True)
class Recorded:
    """Input and output as they were renewed, of which ``block`` samples are one point of the fit, and their noise (N)."""

    channels: tuple[Channel, Channel]
    noise: tuple[float, float]
    block: int


def change_of(t: Array, x: Array, y: Array, recorded: Recorded, whole: float) -> Change | None:
    """Return the one change that explains a run of which any single slip leaves ``whole`` (N), None where there is none."""
    n, span = len(t), float(np.ptp(y))
    if n < 4 * LEAST_POINTS:
        return None
    floor = floor_of(recorded.noise[1], y)
    m = max(1, n // COARSE_POINTS)
    rough = np.ascontiguousarray(x[::m]), np.ascontiguousarray(y[::m])
    places = _places(x, y, recorded)
    tried = {(kind, k): best_fit(*rough, free, floor, behind=Behind(-(-k // m))).rms_n for kind, free in KINDS.items() for k in places}
    kind, k = min(tried, key=lambda a: tried[a])
    if tried[kind, k] > HOPEFUL * whole:
        return None

    def shows(k: int, channel: int, is_gain: bool, found: Cause) -> bool | None:
        return _shown(x, y, recorded, k, channel, is_gain, found)

    # of gain and zero the better one, of the channel that shows it
    best, at = _finest(x, y, kind, k, floor, max(1, n // (CUTS + 1)))
    others = [_finest(x, y, other, at, floor, 2) for other in KINDS if other != kind]
    channel, is_gain = kind
    for (c, gain), (found, when) in zip([other for other in KINDS if other != kind], others, strict=True):
        alone = shows(when, c, gain, found) and not shows(at, channel, is_gain, best)
        if found.rms_n < best.rms_n or (found.rms_n < 1.0 / (1.0 - ALIKE) * best.rms_n and alone):
            channel, is_gain, best, at = c, gain, found, when
    seen = shows(at, channel, is_gain, best)
    if not seen:
        # while the output rests the fit does not tell the sample, the channel does
        steep = [
            (best_fit(x, y, KINDS[channel, is_gain], floor, behind=Behind(k)), k) for k in _steepest((x, y)[channel], recorded, channel)
        ]
        likely = [(c, k) for c, k in steep if c.rms_n < (1.0 + ALIKE) * best.rms_n and shows(k, channel, is_gain, c)]
        best, at, seen = (*likely[0], True) if likely else (best, at, seen)
    if seen is False or not best.rms_n < min((SHOWN if seen else UNSEEN) * whole, LITTLE * span):
        return None
    if min(float(np.ptp(side)) for side in (y[: at - BESIDE], y[at + BESIDE :])) < MOVES * span:
        return None
    if best.rms_n > FRICTION_TOO * _apart(x, y, at, floor):
        return None
    # friction that falls as the input comes to rest lifts an output at a turn, for good where it rests in backlash from there on
    if best.rms_n > (SHOWN if seen else UNSEEN) * by_speed(t, x, y, floor, None, SPEEDS_OVER).rms_n:
        return None
    v = (x, y)[channel]
    # an output that does little but jump once shows no friction on either side
    moves = 2.0 * float(np.ptp(v - np.where(np.arange(n) < at, 0.0, best.size)))
    least, most = (LEAST_GAIN, MOST_GAIN) if is_gain else (LEAST_ZERO * float(np.ptp(v)), moves)
    large = least < abs(best.size) < most
    return Change(channel, is_gain, math.exp(best.size) if is_gain else best.size, float(t[at])) if large else None


def _places(x: Array, y: Array, recorded: Recorded) -> list[int]:
    """Return the points at which a change is tried first: parts of the run, and the steepest steps of both channels."""
    n = len(x)
    found = {part * n // (CUTS + 1) for part in range(1, CUTS + 1)}
    return sorted(found.union(_steepest(x, recorded, 0), _steepest(y, recorded, 1)))


def _steepest(v: Array, recorded: Recorded, channel: int) -> list[int]:
    """Return the points to which a channel goes most, and most beyond what its samples do before and after."""
    steepest = [*channel_of(v).steepest(), *(k // recorded.block for k in recorded.channels[channel].unlikeliest())]
    return [k for k in dict.fromkeys(steepest) if LEAST_POINTS < k < len(v) - LEAST_POINTS]


def _finest(x: Array, y: Array, kind: tuple[int, bool], k: int, floor: float, step: int) -> tuple[Cause, int]:
    """Return the best fit of one change near a sample, and that sample."""
    within = range(LEAST_POINTS + 1, len(x) - LEAST_POINTS)
    return finest(lambda j: best_fit(x, y, KINDS[kind], floor, behind=Behind(j)), k, step, within)


def _apart(x: Array, y: Array, k: int, floor: float) -> float:
    """Return what friction leaves (N) that has a size of its own on either side of a sample."""
    # the fit finds the sample to a few
    sides = [slice(None, max(1, k - BESIDE)), slice(k + BESIDE, None)]
    left = [best_fit(np.ascontiguousarray(x[s]), np.ascontiguousarray(y[s]), bundled(FRICTION), floor).rms_n for s in sides]
    return math.sqrt((k * left[0] ** 2 + (len(x) - k) * left[1] ** 2) / len(x))


def _shown(x: Array, y: Array, recorded: Recorded, k: int, channel: int, is_gain: bool, found: Cause) -> bool | None:
    """Return whether the points, or the samples behind them, show the jump that a change makes, None where it is too small to be seen."""
    # the fit finds the sample to a few
    near = range(max(1, k - BESIDE), min(len(x), k + BESIDE + 1))
    points = shown((channel_of(x), channel_of(y)), recorded.noise, near, channel, is_gain, found.size)
    if points:
        return True
    behind = range(recorded.block * near.start, recorded.block * near.stop)
    return shown(recorded.channels, recorded.noise, behind, channel, is_gain, found.size) or points

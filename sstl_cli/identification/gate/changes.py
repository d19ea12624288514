"""A gain or a zero that changes within a run: friction on both sides of one sample, with one number more behind it.

All four changes (gain or zero, of the output or of the input) are fitted and compared with one another; the sample itself must show it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.causes import (
    FRICTION,
    GAIN_IN_FROM,
    GAIN_OUT_FROM,
    SPEED,
    SPEEDS_OVER,
    ZERO_IN_FROM,
    ZERO_OUT_FROM,
    Behind,
    Cause,
    best_fit,
    bundled,
    fast_of,
    finest,
    floor_of,
)
from sstl_cli.identification.gate.fading import fading_of
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
Place = tuple[tuple[int, bool], int]
Tried = dict[Place, float]
# places of each kind that are tried under another law of friction
FOLLOWED = 2
# parts of the run tried beside the steepest samples of each channel, points of the first search, least points on either side
CUTS, COARSE_POINTS, LEAST_POINTS = 7, 384, 16
# what a change may leave of what any other slip leaves, and of the span: where the sample shows the jump, and where it is too small to be seen there
SHOWN, UNSEEN, LITTLE = 0.6, 0.2, 0.08
# what the first search must leave of it for a second
HOPEFUL = 0.8
# logarithms of a gain: least, and that of a sensor that goes dead; least zero (share of the channel's span)
LEAST_GAIN, MOST_GAIN, LEAST_ZERO = 0.2, 2.5, 0.03
# part of its span that an output must move by on either side: where it rests up to the end, its level there may have come of anything
MOVES = 0.1
# what a change may leave of what friction leaves that is another one on either side
FRICTION_TOO, AS_WELL = 0.5, 1.2


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


@dataclass(frozen=True)
class _Law:
    """Input and output (N) on either side of a change, and by how much friction has changed with speed at every sample (0 to 1), None where it does not."""

    x: Array
    y: Array
    floor: float
    fast: Array | None = None

    def every(self, m: int) -> _Law:
        return self.within(slice(None, None, m))

    def within(self, part: slice) -> _Law:
        return _Law(self.x[part], self.y[part], self.floor, None if self.fast is None else self.fast[part])

    def fit(self, free: tuple[int, ...], since: int | None = None) -> Cause:
        """Return what friction leaves with these parameters free, the last of which counts from a sample on."""
        # friction that changes with speed does so whatever else changes
        free = free if self.fast is None else (SPEED[-1], *free)
        return best_fit(self.x, self.y, free, self.floor, speed=self.fast, behind=Behind(since))


def change_of(t: Array, x: Array, y: Array, recorded: Recorded, whole: float) -> Change | None:
    """Return the one change that explains a run of which any single slip leaves ``whole`` (N), None where there is none.

    Where friction that depends on speed leaves less than that it is asked for the change as well: drag hides a zero that moves, and a zero that moves looks like drag.
    """
    if len(t) < 4 * LEAST_POINTS:
        return None
    floor = floor_of(recorded.noise[1], y)
    law, places = _Law(x, y, floor), _places(x, y, recorded)
    tried = _tried(law, [(kind, k) for kind in KINDS for k in places])
    found = _change(t, law, recorded, whole, tried)
    drag, fast = fast_of(t, x, y, floor, None, SPEEDS_OVER)
    # friction that falls as the input comes to rest lifts an output at a turn, for good where it rests in backlash from there on
    if found is not None and found[1] < found[2] * drag.rms_n:
        return found[0]
    # whatever the law of friction, a change is where it is
    few = [(kind, k) for kind in KINDS for k in sorted(places, key=lambda k: tried[kind, k])[:FOLLOWED]]
    law = _Law(x, y, floor, fast)
    found = _change(t, law, recorded, min(whole, drag.rms_n), _tried(law, few))
    return None if found is None else found[0]


def _change(t: Array, law: _Law, recorded: Recorded, whole: float, tried: Tried) -> tuple[Change, float, float] | None:
    """Return the change under one law of friction, what it leaves (N), and the part of what any rival leaves that it may leave."""
    x, y, n, span = law.x, law.y, len(t), float(np.ptp(law.y))
    likeliest = _likeliest(law, recorded, whole, tried)
    if likeliest is None:
        return None
    (channel, is_gain), best, at, seen = likeliest
    part = SHOWN if seen else UNSEEN
    left = min(best.rms_n, _faded(law, (channel, is_gain), at, best.size)) if seen else best.rms_n
    if seen is False or not left < min(part * whole, LITTLE * span):
        return None
    if min(float(np.ptp(side)) for side in (y[: at - BESIDE], y[at + BESIDE :])) < MOVES * span:
        return None
    # a jump that one channel alone makes is none of friction, which must then but leave no less
    if best.rms_n > (AS_WELL if seen else FRICTION_TOO) * _apart(law, at):
        return None
    v = (x, y)[channel]
    # an output that does little but jump once shows no friction on either side
    moves = 2.0 * float(np.ptp(v - np.where(np.arange(n) < at, 0.0, best.size)))
    least, most = (LEAST_GAIN, MOST_GAIN) if is_gain else (LEAST_ZERO * float(np.ptp(v)), moves)
    large = least < abs(best.size) < most
    change = Change(channel, is_gain, math.exp(best.size) if is_gain else best.size, float(t[at]))
    return (change, left, part) if large else None


def _tried(law: _Law, changes: Sequence[Place]) -> Tried:
    """Return what changes leave (N) on few of the samples."""
    m = max(1, len(law.x) // COARSE_POINTS)
    rough = law.every(m)
    return {(kind, k): rough.fit(KINDS[kind], -(-k // m)).rms_n for kind, k in changes}


def _likeliest(law: _Law, recorded: Recorded, whole: float, tried: Tried) -> tuple[tuple[int, bool], Cause, int, bool | None] | None:
    """Return the kind of the likeliest change, its fit, its sample, and whether that sample shows it; None where none takes much of ``whole`` (N)."""
    x, y, n = law.x, law.y, len(law.x)
    kind, k = min(tried, key=lambda a: tried[a])
    if tried[kind, k] > HOPEFUL * whole:
        return None

    def shows(kind: tuple[int, bool], found: Cause, k: int) -> bool | None:
        return _shown(x, y, recorded, k, *kind, found)

    # of gain and zero the better one, of the channel that shows it
    first, at = _finest(law, kind, k, max(1, n // (CUTS + 1)))
    fits = {kind: (first, at), **{other: _finest(law, other, at, 2) for other in KINDS if other != kind}}
    least = min(found.rms_n for found, _ in fits.values())
    near = [k for k, (found, _) in fits.items() if found.rms_n <= least / (1.0 - ALIKE)]
    kind = min(near, key=lambda k: (not shows(k, *fits[k]), fits[k][0].rms_n))
    best, at = fits[kind]
    seen = shows(kind, best, at)
    if not seen:
        # while the output rests the fit does not tell the sample, the channel does
        steep = [(law.fit(KINDS[kind], k), k) for k in _steepest((x, y)[kind[0]], recorded, kind[0])]
        likely = [(c, k) for c, k in steep if c.rms_n < (1.0 + ALIKE) * best.rms_n and shows(kind, c, k)]
        best, at, seen = (*likely[0], True) if likely else (best, at, seen)
    return kind, best, at, seen


def _places(x: Array, y: Array, recorded: Recorded) -> list[int]:
    """Return the points at which a change is tried first: parts of the run, and the steepest steps of both channels."""
    n = len(x)
    found = {part * n // (CUTS + 1) for part in range(1, CUTS + 1)}
    return sorted(found.union(_steepest(x, recorded, 0), _steepest(y, recorded, 1)))


def _steepest(v: Array, recorded: Recorded, channel: int) -> list[int]:
    """Return the points to which a channel goes most, and most beyond what its samples do before and after."""
    steepest = [*channel_of(v).steepest(), *(k // recorded.block for k in recorded.channels[channel].unlikeliest())]
    return [k for k in dict.fromkeys(steepest) if LEAST_POINTS < k < len(v) - LEAST_POINTS]


def _faded(law: _Law, kind: tuple[int, bool], k: int, size: float) -> float:
    """Return what friction that never forgets where it began leaves (N) once a change is undone."""
    channels = [law.x.copy(), law.y.copy()]
    channel, is_gain = kind
    channels[channel][k:] = channels[channel][k:] * math.exp(-size) if is_gain else channels[channel][k:] - size
    rms = fading_of(*channels)[1]
    return rms if math.isfinite(rms) else math.inf


def _finest(law: _Law, kind: tuple[int, bool], k: int, step: int) -> tuple[Cause, int]:
    """Return the best fit of one change near a sample, and that sample."""
    within = range(LEAST_POINTS + 1, len(law.x) - LEAST_POINTS)
    return finest(lambda j: law.fit(KINDS[kind], j), k, step, within)


def _apart(law: _Law, k: int) -> float:
    """Return what friction leaves (N) that has a size of its own on either side of a sample."""
    # the fit finds the sample to a few
    left = [law.within(s).fit(bundled(FRICTION)).rms_n for s in (slice(None, max(1, k - BESIDE)), slice(k + BESIDE, None))]
    n = len(law.x)
    return math.sqrt((k * left[0] ** 2 + (n - k) * left[1] ** 2) / n)


def _shown(x: Array, y: Array, recorded: Recorded, k: int, channel: int, is_gain: bool, found: Cause) -> bool | None:
    """Return whether the points, or the samples behind them, show the jump that a change makes, None where it is too small to be seen."""
    # the fit finds the sample to a few
    near = range(max(1, k - BESIDE), min(len(x), k + BESIDE + 1))
    points = shown((channel_of(x), channel_of(y)), recorded.noise, near, channel, is_gain, found.size)
    if points:
        return True
    behind = range(recorded.block * near.start, recorded.block * near.stop)
    return shown(recorded.channels, recorded.noise, behind, channel, is_gain, found.size) or points

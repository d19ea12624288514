"""Readings that a live sensor would not repeat so often: those of a channel that is cut off, and of one that stands still.

A repeated value speaks against a sensor only as far as one of this noise, behind a converter of this step, would have read something else meanwhile.
Where no noise tells, the movement does: a channel that is cut off rests while the other one goes on, and one that stood still jumps to where it is by then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.stretches import stretches
from sstl_cli.identification import filtering
from sstl_cli.identification.gate.limits import NOISES, RISES, still_rises
from sstl_cli.identification.gate.live import STUCK_SAMPLES, Live

Array = NDArray[np.float64]
# steps within which a converter's readings say nothing of a movement, and times its own speed behind a rest by which a channel must jump
STEPS, JUMPS = 2.0, 2.0
# readings after a rest that tell how fast the channel goes then
BEHIND = 5
# readings at the last level over those at the level before from which on a channel is cut off (1.2 where it turns)
PILED = 4
# levels by which a channel that is cut off would have gone on, as it came and went, and levels of it that the other channel may go on by meanwhile
CUT, LEVELS = 2.0, 5.0
# noise over the step of a converter from which on a hold does not repeat a level
COARSE = 0.7
# part of its span below which a channel that rests at its lowest may be slack
SLACK = 0.05


@dataclass(frozen=True)
class Rests:
    """Stretches in which a channel repeats an extreme (``label``: which, ``level_n``) or, without one, any reading: the longest (samples), and all of them."""

    longest: int
    count: int
    label: str = ""
    level_n: float = math.nan


def cut_off(values: Array, other: Array | None, live: Live, driven: bool, period_s: float) -> list[Rests]:
    """Return the extremes that a channel repeats though it would have gone beyond them.

    Parameters
    ----------
    values, other : ndarray, shape (n,)
        Readings of the channel and of the other one (N), None where that tells nothing.
    live : Live
        What repeats of the channel say.
    driven : bool
        Whether the channel is the output: it rests at its extreme in backlash as well, but not while the input goes on.
    period_s : float
        Sampling period.
    """
    found = []
    for label, extreme, sign in (("maximum", values.max(), 1.0), ("minimum", values.min(), -1.0)):
        rests = stretches(values == extreme)
        longest, count = max(b - a for a, b in rests), sum(b - a for a, b in rests)
        # a converter repeats a reading where a channel turns, at the last level about as often as at the one before
        near = np.abs(np.abs(values - extreme) - live.step_n) < 0.5 * live.step_n
        before = max(1, int(np.count_nonzero(near))) if live.step_n > 0.0 else 0
        piled = longest >= 3 and count > PILED * before
        if not piled or _beyond(sign * values, sign * extreme) <= CUT * live.step_n:
            continue
        slack = label == "minimum" and abs(extreme) < SLACK * float(np.ptp(values))
        told = other is None or (not slack and _other_goes_on(sign * values, sign * other, rests, live, driven, period_s))
        if longest - 1 > live.most_repeats(len(values)) or told:
            found.append(Rests(longest, count, label, float(extreme)))
    # one channel alone that holds at both of its ends rests at both; a sensor is at its limit at one
    return [] if other is None and len(found) > 1 and filtering.noise_sd(values) <= COARSE * live.step_n else found


def frozen(values: Array, live: Live) -> Rests | None:
    """Return the stretches in which a channel repeats a reading that is none of its extremes, None where a live sensor would as well."""
    same = (np.diff(values) == 0.0) & inside(values)[1:]
    return _told([(a, b) for a, b in stretches(same) if b - a > live.most_repeats(len(values)) or _leaves(values, b + 1, live)])


def frozen_together(channels: tuple[Array, Array], lives: tuple[Live, Live]) -> Rests | None:
    """Return the stretches in which both channels repeat their readings together, None where live sensors would as well."""
    both = replace(lives[0], nats=sum(live.nats for live in lives))
    same = (np.diff(channels[0]) == 0.0) & (np.diff(channels[1]) == 0.0)
    left = [
        (a, b)
        for a, b in stretches(same)
        if b - a > both.most_repeats(len(same)) or any(_leaves(v, b + 1, live) for v, live in zip(channels, lives, strict=True))
    ]
    return _told(left)


def share(values: Array) -> float:
    """Return how often a channel repeats a reading that is none of its extremes: what is clipped must not make the rest look noise-free."""
    moving = inside(values)[1:]
    return float(np.count_nonzero((np.diff(values) == 0.0) & moving)) / max(1, int(np.count_nonzero(moving)))


def _told(found: list[tuple[int, int]]) -> Rests | None:
    lengths = [b - a for a, b in found]
    return Rests(max(lengths), sum(lengths)) if lengths else None


def inside(values: Array) -> NDArray[np.bool_]:
    """Return which readings are none of the extremes of a channel, shape (n,)."""
    return np.asarray((values != values.max()) & (values != values.min()), np.bool_)


def _leaves(values: Array, at: int, live: Live) -> bool:
    """Whether a channel leaves a rest (from sample ``at`` on) by a jump, which a live sensor's movement does not begin with: it goes on as fast then."""
    behind = values[at - 1 : at + 1 + BEHIND]
    if len(behind) < 3:
        return False
    steps = np.abs(np.diff(behind))
    return bool(steps[0] > JUMPS * float(steps[1:].max()) + STEPS * live.step_n + NOISES * live.noise_n)


def _beyond(values: Array, top: float) -> float:
    """Return how far beyond its largest value (N) a channel would have turned, by the slopes at which it comes there and goes.

    A turn that repeats a level is as high as those slopes make it. What rests there as the record begins or ends was seen to do one of both.
    """
    beyond = 0.0
    for a, b in stretches(values == top):
        if b - a >= 3 and a >= 3 and b + 2 < len(values):
            slopes = max(values[a - 1] - values[a - 3], 0.0) + max(values[b] - values[b + 2], 0.0)
            # half of the mean slope at either end, over half of the time between
            beyond = max(beyond, 0.0625 * slopes * (b - a + 1) - (top - max(values[a - 1], values[b])))
    return float(beyond)


def _other_goes_on(values: Array, other: Array, rests: list[tuple[int, int]], live: Live, driven: bool, period_s: float) -> bool:
    """Whether the other channel goes on while this one rests at its highest, by more than a held input or an output in backlash leaves to it."""
    reach = float(np.ptp(other))
    least = max(RISES * reach, NOISES * filtering.noise_sd(other), LEVELS * live.step_n * reach / float(np.ptp(values)))
    for a, b in rests:
        if b - a < STUCK_SAMPLES:
            continue
        part = other[a:b]
        rises = (
            float(np.max(part)) - filtering.median(part[:3])
            if driven
            else still_rises(np.linspace(0.0, period_s * (b - a - 1), b - a), part)
        )
        if rises > least:
            return True
    return False

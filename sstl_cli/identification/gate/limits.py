"""A sensor at the end of its range: it rests at its extreme while the other channel goes on, and friction behind such a sensor explains the run."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.core.stretches import stretches
from sstl_cli.identification.filtering import median, quantile
from sstl_cli.identification.gate.causes import FRICTION, Behind, Causes, best_fit, bundled, floor_of

Array = NDArray[np.float64]
# spreads of the noise within which a channel rests at its extreme, part of the run and stretches that it must rest in, their least length (s and points)
REST, REST_SHARE, STRETCHES, LEAST_S, LEAST_POINTS = 3.0, 0.05, 2, 0.5, 8
# time (s) after which no slow channel catches up any more, and what the other channel must then go on by (part of its span, and noise)
CAUGHT_UP_S, GOES_ON, NOISES = 0.4, 0.05, 8.0
# and the time (s) after which a channel that is only late is there: what still rises then and has gone but this part of its way in half of the time to
# 0.95 of it goes on as it came (0.53, under the top of a sine 0.66), where what catches up slows down (0.82)
LATE_S, NEARLY, HALFWAY = 0.2, 0.95, 0.74
# how long (s) a speed is measured before a rest and after LATE_S of it, and the part of it that an output keeps where its input goes on unseen: at a true hold
# nothing but creep is left, a part of the friction
BEGINS_S, KEEPS = 0.15, 0.4
# parts of a rest over which the means of an output show how it rises, the part of friction that relaxes at the most, and of the rest after which it still rises then
CREEP_PARTS, RELAXES, TO_THE_END = 24, 0.5, 0.7
# rises (part of its span) of the other channel in two rests, and how far apart it must then end: after a true hold it ends at one level
RISES, APART = 0.08, 0.12
# levels of a converter over the span below which an extreme says nothing
COARSE = 0.03
# what friction behind a sensor at its limit may leave of what friction, alone or with any other slip, leaves
BETTER = 0.6
# steps of a converter in the noise from which on a reading does not come many times in a row by chance
STEPS = 3.0
# part of what the input moves by that an output must
MOVES = 0.1
# time constants (s) of a slow output that are tried, and what they may leave of what friction leaves
SLOW_S, CATCHES_UP = (0.15, 0.4, 1.0, 2.5), 0.5


def limits_of(
    points: tuple[Array, Array, Array], noise: tuple[float, float], steps: tuple[float, float], causes: Causes
) -> tuple[float, float]:
    """Return the levels (N) that input and output do not pass while the other one goes on, NaN where there is none."""
    t, x, y = points
    wrap = causes.friction.wrap
    into = limit_of(t, x, y, noise, steps[0], wrap=wrap)
    # one that goes on at its speed is not about to catch up: a low-pass must then explain more of it
    catches_up = CATCHES_UP * (0.5 if math.isfinite(limit_of(t, x, y, noise, steps[0], as_it_came=True, wrap=wrap)) else 1.0)
    if math.isfinite(into) and _slow(t, x, y, noise[1], causes, catches_up):
        into = math.nan
    # an output that hardly leaves its backlash tells no friction to be compared with
    if causes.enough or steps[1] > COARSE * float(np.ptp(y)) or float(np.ptp(y)) < MOVES * float(np.ptp(x)):
        return into, math.nan
    out = limit_of(t, y, x, noise[::-1], steps[1], driven=True)
    return into, out if math.isfinite(out) and _cut_off(x, y, noise[1], out, causes) else math.nan


def end_of(v: Array, other: Array, noise_n: float, step_n: float) -> float:
    """Return the highest reading (N) of a channel that repeats it to the last digit again and again against its noise, NaN where it does not.

    A reading with noise comes again by chance for a few samples, and a sensor that stops does so anywhere and once. What is held by a slower
    sensor has to be left out before: it repeats every reading.
    """
    top = float(np.max(v))
    if not noise_n > STEPS * step_n:
        return math.nan
    ends = [(a, b) for a, b in stretches(v == top) if b - a >= LEAST_POINTS]
    moved = max((float(np.ptp(other[a:b])) for a, b in ends), default=0.0)
    shown = len(ends) >= STRETCHES and float(np.mean(v == top)) > REST_SHARE
    return top if shown and moved > GOES_ON * float(np.ptp(other)) else math.nan


def _cut_off(x: Array, y: Array, noise_n: float, level: float, causes: Causes) -> bool:
    """Whether friction behind a sensor that stops at ``level`` (N) explains an output much better than friction, alone or with any other slip."""
    rest = min(causes.left(c.rms_n) for c in (*causes.slips, causes.reversed))
    found = best_fit(x, y, bundled(FRICTION), floor_of(noise_n, y), behind=Behind(most_n=level))
    return causes.left(found.rms_n) < BETTER * rest


def _slow(t: Array, x: Array, y: Array, noise_n: float, causes: Causes, part: float) -> bool:
    """Whether an output that follows slowly explains that it goes on while the input rests."""
    dt, floor = median(np.diff(t)), floor_of(noise_n, y)
    left = min(causes.left(best_fit(_lagged(x, dt / tau), y, bundled(FRICTION), floor).rms_n) for tau in SLOW_S)
    return left < part * causes.left(causes.friction.rms_n)


@njit(cache=True, nogil=True)
def _lagged(v: Array, part: float) -> Array:
    """Return a channel behind a filter of first order; ``part`` is the sampling period over its time constant."""
    out, state = np.empty(v.size), v[0]
    for k in range(v.size):
        state += (1.0 - math.exp(-part)) * (v[k] - state)
        out[k] = state
    return out


def limit_of(
    t: Array,
    v: Array,
    other: Array,
    noise: tuple[float, float],
    step: float = 0.0,
    driven: bool = False,
    as_it_came: bool = False,
    wrap: float = 0.0,
) -> float:
    """Return the level (N) of a channel that it does not pass though the other one goes on, NaN where there is none.

    An input that is held leaves the output where it is; an output (``driven``) rests in backlash, but not at its largest while
    the input grows. Where it must go on ``as_it_came`` it does not slow down meanwhile. What friction of n theta (``wrap``) makes of a rest
    as it relaxes is none.
    """
    high = quantile(v, 0.999)
    if step > COARSE * float(np.ptp(v)):
        return math.nan
    span, reach = float(np.ptp(v)), float(np.ptp(other))
    rest = 2.0 * REST * max(noise[0], 1e-3 * span)
    near = v > high - rest
    if not REST_SHARE < float(np.mean(near)) < 0.9 or span <= 0.0 or reach <= 0.0:
        return math.nan
    # a channel that moves by what counts as rest moves the other one
    band = rest * reach / span
    rests = [(a, b) for a, b in stretches(near) if a > 0 and b - a >= LEAST_POINTS and t[b - 1] - t[a] > LEAST_S]
    rests = [(a, b) for a, b in rests if _flat(v[a:b], max(noise[0], 1e-3 * span))]
    if len(rests) < STRETCHES:
        return math.nan
    if driven:
        # in backlash the output stays at its largest while the input comes and goes, but not beyond where it was when it came there
        came = max(float(other[a]) for a, _ in rests)
        went = [float(np.max(other[a:b])) - came for a, b in rests]
    else:
        driving = [not _brakes(t, other, a, noise[1]) and not _creeps(other[a:b], wrap) for a, b in rests]
        ends = [other[a:b] for (a, b), goes in zip(rests, driving, strict=True) if goes]
        if not as_it_came and _ends_apart(ends, band + max(RISES * reach, NOISES * noise[1]), reach):
            return high
        way = still_rises if as_it_came else _went_on
        went = [way(t[a:b], other[a:b]) if goes else 0.0 for (a, b), goes in zip(rests, driving, strict=True)]
    least = band + max((RISES if driven else GOES_ON) * reach, NOISES * noise[1])
    return high if sum(w > least for w in went) >= max(STRETCHES, 0.5 * len(went)) else math.nan


def _flat(v: Array, spread: float) -> bool:
    """Whether a channel rests at its extreme: what turns there is lower at both ends."""
    inner = v[len(v) // 6 : len(v) - len(v) // 6]
    return float(np.ptp([median(part) for part in np.array_split(inner, 3)])) < spread


def _brakes(t: Array, other: Array, at: int, noise_n: float) -> bool:
    """Whether an output that came with its input slows down at once where that begins to rest, as no output does whose input goes on."""
    times = t[at] + np.array([-BEGINS_S, 0.0, LATE_S, LATE_S + BEGINS_S])
    before, begun, late, later = np.interp(times, t, other)
    return bool(begun - before > NOISES * noise_n and later - late < KEEPS * (begun - before))


def _creeps(other: Array, wrap: float) -> bool:
    """Whether an output rises during a rest of its input as friction relaxes: by a part of what friction takes, fastest at once and ever more slowly, or on to the end.

    A movement that goes beyond a limit comes back to it, and its output rests meanwhile.
    """
    # of the means of some samples none is highest by its noise alone
    parts = np.array([float(np.mean(part)) for part in np.array_split(other, min(CREEP_PARTS, len(other)))])
    begun, top = median(other[:3]), float(parts.max())
    if not 0.0 < begun < top or math.log(top / begun) > RELAXES * wrap:
        return False
    way = (parts - begun) / (top - begun)
    at = int(np.argmax(way >= NEARLY))
    return bool(at > TO_THE_END * len(way) or way[at // 2] > HALFWAY / NEARLY * way[at])


def _ends_apart(rests: list[Array], least: float, reach: float) -> bool:
    """Whether an output rises while its input rests at its largest, and ends at another level each time."""
    ends = [float(np.max(v)) for v in rests if float(np.max(v) - np.median(v[:3])) > least]
    return len(ends) >= STRETCHES and float(np.ptp(ends)) > APART * max(reach, float(np.median(ends)))


def _went_on(t: Array, other: Array) -> float:
    """Return by how much a channel still rises (N) once no slow channel catches up any more."""
    few = max(1, len(t) // 20)
    k = int(np.searchsorted(t, t[0] + CAUGHT_UP_S))
    rise = float(np.max(other[k:]) - median(other[k : k + few])) if k + few < len(t) else 0.0
    return max(rise, still_rises(t, other))


def still_rises(t: Array, other: Array) -> float:
    """Return by how much a channel still rises (N) once one that is only late is there, if it does not slow down meanwhile."""
    late = t - t[0] > LATE_S
    t, v = t[late], other[late]
    if len(v) < LEAST_POINTS:
        return 0.0
    way = v - v[0]
    top = int(np.argmax(way))
    at = int(np.argmax(way >= NEARLY * way[top]))
    return float(way[top]) if at >= LEAST_POINTS and float(way[at // 2]) < HALFWAY / NEARLY * float(way[at]) else 0.0

"""Which single slip explains a run: the same play operator with the few parameters that friction has, and one slip more.

The free lines of ``playfit`` explain much that no tendon does. Here the lines are those of friction, and what a slip leaves
of the output is compared with what friction alone leaves: only a slip that the samples hold is named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median, quantile
from sstl_cli.identification.gate.fading import fading_of, scaled_fading_of
from sstl_cli.identification.gate.movement import WAY, both_ways
from sstl_cli.identification.gate.playfit import PlayFit
from sstl_cli.identification.gate.strands import CREEPS, LAG, PARAMETERS, SPREAD, descend, played, tried

Array = NDArray[np.float64]
FRICTION, GAIN, SPEED, SLOW = (0, 2), (0, 2, 1), (0, 1, 2, 5), (0, 1, 2, LAG)
ZERO_IN, ZERO_OUT, CREEP = (0, 3), (0, 4), (0, 1, 2, CREEPS)
GAIN_BESIDE, GAIN_BESIDE_IN = (0, 2, 4, 1), (0, 2, 3, 1)
GAIN_OUT_FROM, GAIN_IN_FROM, ZERO_OUT_FROM, ZERO_IN_FROM = (0, 2, 4, 7), (0, 2, 4, 8), (0, 2, 4, 9), (0, 2, 4, 10)
# times what the best explanation leaves that another one may leave to be as likely
APIECE = 2.0
# part of a run that an output may be moved by for what is left to count: what lies beyond its ends is not compared
MOVED = 0.2
# first guess of the spread of the strands' friction
FIRST_SPREAD = 0.4
# first guesses of n theta: a nearly straight tube, and bends of one and of two passes
STARTS = (0.05, 0.15, 0.3, 0.5, 0.8, 1.2, 1.8)
STEPS, TRIED = 25, 2
# part of a recording that must still overlap once it is moved in time
LEAST_OVERLAP = 0.5
# points on which a delay is sought, first step of the search (part of the first guess) and its last one
TIMED_POINTS, DELAY_STEP, DELAY_SHARE = 384, 0.25, 0.02
# points over which a speed is measured (and those over which it shows behind noise as well), and parts of the samples that are slower than the speed at which friction has changed
SPEED_OVER, SPEEDS_OVER, SLOWER = (5,), (5, 11, 21), (0.3, 0.8)
# first guesses of the time constant of a slow output (s)
SLOW_S = (0.2, 0.5, 1.2, 3.0)
# a slip must take away most of what friction leaves beyond noise, and friction must leave more than noise
TAKES, MORE = 0.5, 2.0
# part of the output's span that friction leaves at the least of a channel with another scale
LITTLE = 0.02
# standard errors from which on a clock drifts
DRIFTS = 8.0


def bundled(free: tuple[int, ...]) -> tuple[int, ...]:
    """Return the free parameters of a hypothesis, the spread of the strands with them."""
    return (SPREAD, *free)


@dataclass(frozen=True)
class Cause:
    """One hypothesis: n theta, the size of the slip (in the unit of the slip) and the residual (N) it leaves; ``zero_n`` is a zero that is free beside it."""

    wrap: float
    size: float
    rms_n: float
    zero_n: float = 0.0


@dataclass(frozen=True)
class Behind:
    """What stands between friction and its reading: another gain or zero from sample ``since`` on, a level (N) that the sensor does not pass,
    or a low-pass, of which these are guesses (logarithm of the time constant in samples).
    """

    since: int | None = None
    most_n: float = math.inf
    lags: tuple[float, ...] = ()


NOTHING_BEHIND = Behind()


@dataclass(frozen=True)
class Causes:
    """What friction alone leaves of a run, and what it leaves with one slip: a gain, a zero, a delay, a low-pass of the output,
    a zero that creeps, or time reversed.

    ``scale`` is the gain beside a zero of the output that is free as well, ``scale_in`` that beside one of the input: how large a gain is where there is one,
    as sensors are tared to some percent, which a gain alone takes for its own, and another scale (volts) where both are far off.

    ``speed`` is no slip but friction that falls or rises with speed, which moves the loop in time as well; it is asked for where a slip takes much away.

    Where friction alone leaves more than noise it may build up over a path in all of them: a bundle of plays, whose strands slide one after the other.

    ``fading`` is no slip either but friction that builds up over a path so long that it never forgets where it began.

    ``noise_n`` is the noise of both sensors as the output shows it. NaN where nothing was compared: slips are not where
    friction leaves but noise.
    """

    noise_n: float
    friction: Cause
    gain: Cause
    zero_in: Cause
    zero_out: Cause
    moved: Cause
    reversed: Cause
    slow: Cause
    speed: Cause
    creep: Cause
    scale: Cause
    scale_in: Cause
    fading: Cause

    @property
    def enough(self) -> bool:
        """Whether friction alone leaves but noise, so that the samples hold nothing else."""
        return self.noise_alone(self.friction.rms_n)

    def noise_alone(self, rms_n: float) -> bool:
        """Whether a residual (N) is but noise."""
        return rms_n <= MORE * self.noise_n

    @property
    def slips(self) -> tuple[Cause, ...]:
        """Return friction alone, that by speed and that which fades, and with each slip that leaves the order of the samples as it is."""
        return self.friction, self.gain, self.zero_in, self.zero_out, self.moved, self.slow, self.speed, self.creep, self.fading

    def likely(self, apiece: float, among: Iterable[Cause] | None = None) -> tuple[Cause, ...]:
        """Return those of several explanations (of all slips, friction alone among them) that leave but noise, or at most ``apiece`` times what the best of them leaves beyond it."""
        known = [c for c in (self.slips if among is None else among) if math.isfinite(c.rms_n)]
        least = min((self.left(c.rms_n) for c in known), default=0.0)
        return tuple(c for c in known if self.noise_alone(c.rms_n) or self.left(c.rms_n) <= apiece * least)

    def least_n(self, duration_s: float) -> float:
        """Return what friction leaves of a run with the slip that explains most (N RMS), 0 where nothing was compared."""
        known = [c for c in (*self.slips, self.reversed) if c is not self.moved or not abs(c.size) > MOVED * duration_s]
        return min((c.rms_n for c in known if math.isfinite(c.rms_n)), default=0.0)

    def left(self, rms_n: float) -> float:
        """Return a residual (N) without the noise."""
        return math.sqrt(max(rms_n**2 - self.noise_n**2, 0.0)) if math.isfinite(rms_n) else math.inf

    def holds(self, rms_n: float, takes: float = TAKES) -> bool:
        """Whether a slip that leaves ``rms_n`` is held by the samples: friction alone leaves far more than it and than noise."""
        return not self.enough and self.left(rms_n) < takes * self.left(self.friction.rms_n)


UNKNOWN = Cause(math.nan, math.nan, math.nan)
NO_CAUSES = Causes(math.nan, *[UNKNOWN] * 12)


def causes_of(time_s: Array, x: Array, y: Array, noise: tuple[float, float], play: PlayFit) -> Causes:
    """Return what friction leaves of a run, alone and with one slip.

    Parameters
    ----------
    time_s, x, y : ndarray, shape (n,)
        Time in s, input and output in N.
    noise : tuple of float
        White noise of both (N).
    play : PlayFit
        The free lines, and the delay that is tried.
    """
    floor = floor_of(noise[1], y)
    friction = best_fit(x, y, FRICTION, floor, play)
    found = Causes(math.hypot(noise[1], math.exp(-friction.wrap) * noise[0]), friction, *[UNKNOWN] * 11)
    if found.enough:
        return found
    bundle = best_fit(x, y, bundled(FRICTION), floor, play)
    found = replace(found, friction=min(friction, bundle, key=lambda c: c.rms_n))
    if found.enough:
        return found
    # one way any law is a line, and a gain as well
    fades = both_ways(x, noise[0]) >= WAY
    wrap, left = fading_of(x, y) if fades else (math.nan, math.nan)
    found = replace(
        found,
        fading=Cause(wrap, math.nan, left),
        gain=min([best_fit(x, y, bundled(GAIN), floor, play), *([_scaled_fading(x, y)] if fades else [])], key=lambda c: c.rms_n),
        zero_in=best_fit(x, y, bundled(ZERO_IN), floor, play),
        zero_out=best_fit(x, y, bundled(ZERO_OUT), floor, play),
        moved=_moved(time_s, x, y, floor, play),
        slow=_slow(time_s, x, y, floor),
        creep=best_fit(x, y, bundled(CREEP), floor, play),
        reversed=best_fit(np.ascontiguousarray(x[::-1]), np.ascontiguousarray(y[::-1]), bundled(GAIN), floor),
    )
    if found.friction.rms_n > LITTLE * float(np.ptp(y)) or found.holds(found.gain.rms_n):
        scales = [
            min(best_fit(x, y, bundled(free), floor, play), found.gain, key=lambda c: c.rms_n) for free in (GAIN_BESIDE, GAIN_BESIDE_IN)
        ]
        found = replace(found, scale=scales[0], scale_in=scales[1])
    taken = (found.zero_in, found.zero_out, found.moved, found.slow, found.creep, found.reversed)
    return replace(found, speed=by_speed(time_s, x, y, floor, play)) if any(found.holds(c.rms_n) for c in taken) else found


def _scaled_fading(x: Array, y: Array) -> Cause:
    """Return what friction that never forgets where it began leaves with a gain."""
    wrap, gain, rms = scaled_fading_of(x, y)
    return Cause(wrap, gain, rms if math.isfinite(rms) else math.inf)


def finest(fit: Callable[[int], Cause], k: int, step: int, within: range) -> tuple[Cause, int]:
    """Return the best fit near a sample, and that sample, by halving steps."""
    tried = {k: fit(k)}
    while step > 1:
        step //= 2
        tried.update({j: fit(j) for j in (k - step, k + step) if j not in tried and j in within})
        k = min(tried, key=lambda j: tried[j].rms_n)
    return tried[k], k


def floor_of(noise_n: float, y: Array) -> float:
    """Return what no fit of an output is told to leave less than (N): its noise, or a ten-thousandth of its span."""
    return max(noise_n, 1e-4 * float(np.ptp(y)))


def by_speed(time_s: Array, x: Array, y: Array, floor: float, play: PlayFit | None, over: tuple[int, ...] = SPEED_OVER) -> Cause:
    """Return what friction that changes with speed leaves; of the speed at which it has changed two are tried, measured ``over`` so many points."""
    return fast_of(time_s, x, y, floor, play, over)[0]


def fast_of(
    time_s: Array, x: Array, y: Array, floor: float, play: PlayFit | None, over: tuple[int, ...] = SPEED_OVER
) -> tuple[Cause, Array]:
    """Return what friction that changes with speed leaves, and by how much of its change it has changed at every sample (0 to 1)."""
    tried = [(best_fit(x, y, bundled(SPEED), floor, play, fast), fast) for n in over for fast in _fast(time_s, x, n)]
    return min(tried, key=lambda c: c[0].rms_n)


def _fast(time_s: Array, x: Array, n: int) -> list[Array]:
    smooth = np.convolve(np.pad(x, n // 2, mode="edge"), np.full(n, 1.0 / n), "valid")
    speed = np.abs(np.gradient(smooth, time_s))
    scales = [max(quantile(speed, part), 1e-3 * float(speed.max()), 1e-300) for part in SLOWER]
    return [-np.expm1(-speed / scale) for scale in scales]


def _moved(time_s: Array, x: Array, y: Array, floor: float, play: PlayFit) -> Cause:
    """Return what is left of an output that is moved in time; of its ``size`` (s) too little may overlap to tell.

    Free lines take a part of a delay for friction, so that theirs is but the first guess. A clock that drifts as well moves it by more and more.
    """
    drift = play.drift if abs(play.drift) > DRIFTS * play.drift_se else 0.0
    turned = drift * (time_s - 0.5 * float(time_s[0] + time_s[-1]))
    every = max(1, len(x) // TIMED_POINTS)

    def fit(delay: float, stride: int) -> Cause:
        at = time_s + delay + turned
        inside = (at >= time_s[0]) & (at <= time_s[-1])
        if np.count_nonzero(inside) < LEAST_OVERLAP * len(time_s):
            return UNKNOWN
        moved = np.interp(at[inside], time_s, y)
        return best_fit(x[inside][::stride], moved[::stride], bundled(GAIN), floor)

    period = median(np.diff(time_s))
    best, step = play.delay_s, max(DELAY_STEP * abs(play.delay_s), period)
    left = {best: fit(best, every).rms_n}
    while step > 0.25 * period and step > DELAY_SHARE * abs(best) and math.isfinite(left[best]):
        for delay in (best - step, best + step):
            if delay not in left:
                left[delay] = fit(delay, every).rms_n
        nearest = min((d for d in left if math.isfinite(left[d])), key=lambda d: left[d])
        best, step = nearest, (step if nearest != best else 0.5 * step)
    return replace(fit(best, 1), size=best)


def _slow(time_s: Array, x: Array, y: Array, floor: float) -> Cause:
    """Return what is left of an output behind a low-pass of its own, whose time constant (s) is the ``size``."""
    period = median(np.diff(time_s))
    slow = best_fit(x, y, bundled(SLOW), floor, behind=Behind(lags=tuple(math.log(s / period) for s in SLOW_S)))
    return replace(slow, size=period * math.exp(slow.size))


def best_fit(
    x: Array,
    y: Array,
    free: tuple[int, ...],
    floor: float,
    play: PlayFit | None = None,
    speed: Array | None = None,
    behind: Behind = NOTHING_BEHIND,
) -> Cause:
    """Return the best descent from the likeliest first guesses; ``size`` is that of the slip among the free parameters."""
    return modelled(x, y, free, floor, play, speed, behind)[0]


def modelled(
    x: Array,
    y: Array,
    free: tuple[int, ...],
    floor: float,
    play: PlayFit | None = None,
    speed: Array | None = None,
    behind: Behind = NOTHING_BEHIND,
) -> tuple[Cause, Array]:
    """Return the best descent, and what it makes of the output (N) at all samples, those that are NaN with them."""
    # each layout of memory would be compiled for itself
    x, y = np.ascontiguousarray(x), np.ascontiguousarray(y)
    fast = np.zeros(len(x)) if speed is None else np.ascontiguousarray(speed)
    which, begins = np.array(free, np.int64), len(x) if behind.since is None else behind.since
    slip = free[-1]
    given = np.array([median(y[~np.isnan(y)][:3]), begins, behind.most_n, float(bool(behind.lags))])
    guesses = [guess(wrap, free) for wrap in STARTS]
    if behind.lags:
        guesses = [np.concatenate((p[:LAG], [lag], p[LAG + 1 :])) for p in guesses for lag in behind.lags]
    elif slip not in (FRICTION[-1], CREEPS):
        level = _level(x, y, slip, begins)
        for p in guesses.copy():
            guesses.append(p.copy())
            guesses[-1][slip] = level
    if play is not None and 0.0 < play.gamma_p < play.gamma_r:
        # where the free lines meet is no tension
        wrap, at = 0.5 * math.log(play.gamma_r / play.gamma_p), (play.beta_p - play.beta_r) / (play.gamma_r - play.gamma_p)
        likely = {1: 0.5 * math.log(play.gamma_p * play.gamma_r), 3: at, 4: play.beta_p + play.gamma_p * at}
        guesses.append(guess(min(wrap, 2.0), free))
        # beside a gain the zero is far off as well; beside other slips what is free else begins at nothing
        for i in {slip, 3, 4} & set(free) if slip == 1 else {slip}:
            guesses[-1][i] = likely.get(i, 0.0)
    guesses.sort(key=lambda p: tried(x, y, fast, p, given, floor))
    found = [descend(x, y, fast, which, p, given, floor, STEPS) for p in guesses[:TRIED]]
    p, rms = min(found, key=lambda f: f[1])
    return Cause(float(p[0]), float(p[slip]), float(rms), float(p[3] + p[4])), played(x, fast, p, given)


def guess(wrap: float, free: tuple[int, ...]) -> Array:
    """Return a first guess of all parameters that holds n theta, and a spread where that is free."""
    p = np.zeros(PARAMETERS)
    p[0], p[SPREAD] = wrap, FIRST_SPREAD if SPREAD in free else 0.0
    return p


def _level(x: Array, y: Array, slip: int, since: int) -> float:
    """Return the size of a slip that middle levels show: friction of both directions leaves them alike, a slip does not."""
    a, b = median(x), float(np.nanmedian(y))
    if slip in (1, 3, 4, 5):
        return {1: math.log(b / a) if a > 0.0 and b > 0.0 else 0.0, 3: a - b, 4: b - a, 5: -0.2}[slip]
    before, after = ((float(np.median(x[part])), float(np.median(y[part]))) for part in (slice(None, since), slice(since, None)))
    if slip in (7, 8):
        if min(*before, *after) <= 0.0:
            return 0.0
        change = math.log(after[1] / after[0] * before[0] / before[1])
        return change if slip == 7 else -change
    change = after[1] - after[0] * before[1] / before[0] if before[0] != 0.0 else 0.0
    return change if slip == 9 else -change

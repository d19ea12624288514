"""Which single slip explains a run: the same play operator with the few parameters that friction has, and one slip more.

The free lines of ``playfit`` explain much that no tendon does. Here the lines are those of friction, and what a slip leaves
of the output is compared with what friction alone leaves: only a slip that the samples hold is named.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.identification.gate.playfit import PlayFit

Array = NDArray[np.float64]
# parameters: n theta, logarithm of the gain, constant friction (N), zero of the input (N), zero of the output (N), part of n theta that speed adds,
# spread of the friction of single strands (presliding); from one sample on: logarithms of another gain of output and input, other zeros of output
# and input (N); logarithm of the time constant (samples) of a low-pass behind the output; what the output's zero gains along the run (N). The slip comes last.
SPREAD, STEADY, LAG, CREEPS, PARAMETERS = 6, 7, 11, 12, 13
FRICTION, GAIN, SPEED, SLOW = (0, 2), (0, 2, 1), (0, 1, 2, 5), (0, 1, 2, LAG)
ZERO_IN, ZERO_OUT, CREEP = (0, 3), (0, 4), (0, 1, 2, CREEPS)
GAIN_OUT_FROM, GAIN_IN_FROM, ZERO_OUT_FROM, ZERO_IN_FROM = (0, 2, 7), (0, 2, 8), (0, 2, 9), (0, 2, 10)
# friction that builds up over a path is a bundle of strands that slide one after the other: their places in a normal distribution (fifths of it),
# first guess of the spread (of the logarithm of their friction) and its largest
STRANDS, FIRST_SPREAD, MOST_SPREAD = np.array([-1.4, -0.532, 0.0, 0.532, 1.4]), 0.4, 1.2
# first guesses of n theta: a nearly straight tube, and bends of one and of two passes
STARTS = (0.05, 0.15, 0.3, 0.5, 0.8, 1.2, 1.8)
STEPS, HUBER, TRIED = 25, 2.0, 2
# part of a recording that must still overlap once it is moved in time
LEAST_OVERLAP = 0.5
# points on which a delay is sought, first step of the search (part of the first guess) and its last one
TIMED_POINTS, DELAY_STEP, DELAY_SHARE = 384, 0.25, 0.02
# points over which a speed is measured, and parts of the samples that are slower than the speed at which friction has changed
SPEED_OVER, SLOWER = 5, (0.3, 0.8)
# first guesses of the time constant of a slow output (s), and the range of its logarithm in samples: a tenth, and more than any recording has
SLOW_S, FASTEST, SLOWEST = (0.2, 0.5, 1.2, 3.0), -2.3, 12.0
# a slip must take away most of what friction leaves beyond noise, and friction must leave more than noise
TAKES, MORE = 0.5, 2.0
# standard errors from which on a clock drifts
DRIFTS = 8.0


def bundled(free: tuple[int, ...]) -> tuple[int, ...]:
    """Return the free parameters of a hypothesis, the spread of the strands with them."""
    return (SPREAD, *free)


@dataclass(frozen=True)
class Cause:
    """One hypothesis: n theta, the size of the slip (in the unit of the slip) and the residual (N) it leaves."""

    wrap: float
    size: float
    rms_n: float


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

    ``speed`` is no slip but friction that falls or rises with speed, which moves the loop in time as well; it is asked for where a slip takes much away.

    Where friction builds up over a path (``bundled``), it does so in all of them: a bundle of plays, whose strands slide one after the other.

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
    bundled: bool = False

    @property
    def enough(self) -> bool:
        """Whether friction alone leaves but noise, so that the samples hold nothing else."""
        return self.friction.rms_n <= MORE * self.noise_n

    @property
    def slips(self) -> tuple[Cause, ...]:
        """Return friction alone, that by speed, and with each slip that leaves the order of the samples as it is."""
        return self.friction, self.gain, self.zero_in, self.zero_out, self.moved, self.slow, self.speed, self.creep

    def freed(self, free: tuple[int, ...]) -> tuple[int, ...]:
        """Return the free parameters of a hypothesis about this run: the spread of its strands with them where its friction has one."""
        return bundled(free) if self.bundled else free

    def left(self, rms_n: float) -> float:
        """Return a residual (N) without the noise."""
        return math.sqrt(max(rms_n**2 - self.noise_n**2, 0.0)) if math.isfinite(rms_n) else math.inf

    def holds(self, rms_n: float, takes: float = TAKES) -> bool:
        """Whether a slip that leaves ``rms_n`` is held by the samples: friction alone leaves far more than it and than noise."""
        return not self.enough and self.left(rms_n) < takes * self.left(self.friction.rms_n)


UNKNOWN = Cause(math.nan, math.nan, math.nan)
NO_CAUSES = Causes(math.nan, *[UNKNOWN] * 9)


# long: one pass over the samples, whose state is what the next sample starts from
@njit(cache=True, nogil=True)
def _residual(x: Array, y: Array, fast: Array, p: Array, given: Array, left: Array, jacobian: Array) -> None:
    """Write output minus play operators, and their derivatives with respect to all parameters.

    ``fast`` (0 to 1) is the speed; ``given`` are the output (N) at the beginning, the sample from which another gain or zero counts, the
    level (N) that the sensor does not pass, and whether it is slow. Where the output is NaN nothing is left, and nothing known.
    """
    since, most, slow = given[1], given[2], given[3] > 0.0
    strands = STRANDS.size if p[SPREAD] > 0.0 else 1
    ratio, by_spread = _strands(p[SPREAD], strands)
    gp, gr = np.exp(p[1] - p[0] * ratio), np.exp(p[1] + p[0] * ratio)
    v, s = np.full(strands, given[0]), np.zeros((strands, STEADY))
    moved, moved_by = np.zeros(strands), np.zeros(strands)
    part = 1.0
    changes = since < x.size
    gain_out, gain_in, zero_out, zero_in = 1.0, 1.0, 0.0, 0.0
    for k in range(x.size):
        if p[5] != 0.0:
            part = max(1.0 + p[5] * fast[k], 0.0)
            gp, gr = np.exp(p[1] - p[0] * part * ratio), np.exp(p[1] + p[0] * part * ratio)
        if k == since:
            gain_out, gain_in, zero_out, zero_in = math.exp(p[7]), math.exp(-p[8]), p[9], p[10]
        pulled = (x[k] - zero_in) * gain_in - p[3]
        total = 0.0
        for i in range(strands):
            r = ratio[i]
            low, high = gp[i] * pulled - p[2] * r + p[4], gr[i] * pulled + p[2] * r + p[4]
            if high < low:
                # below no tension both lines have crossed
                low = high = 0.5 * (low + high)
            sign = 0.0
            if v[i] < low:
                v[i], on, sign = low, gp[i], -1.0
            elif v[i] > high:
                v[i], on, sign = high, gr[i], 1.0
            if sign != 0.0:
                a = on * pulled
                s[i, 0], s[i, 1], s[i, 2], s[i, 3], s[i, 4] = sign * a * part * r, a, sign * r, -on, 1.0
                s[i, 5], s[i, SPREAD] = sign * a * p[0] * fast[k] * r, sign * (a * part * p[0] + p[2]) * by_spread[i]
                # a strand at rest keeps the input's gain and zero with which it slid last
                moved[i] = on * gain_in if k >= since else 0.0
                moved_by[i] = moved[i] * (x[k] - zero_in)
            total += v[i]
        model = total / strands
        along = k / (x.size - 1.0)
        shown = gain_out * model + zero_out + p[CREEPS] * along
        held = shown > most
        left[k] = y[k] - (most if held else shown)
        if math.isnan(left[k]):
            # what the sensor did not tell counts for nothing
            held, left[k] = True, 0.0
        for j in range(STEADY):
            mean = 0.0
            for i in range(strands):
                mean += s[i, j]
            jacobian[k, j] = 0.0 if held else gain_out * mean / strands
        jacobian[k, CREEPS] = 0.0 if held else along
        if changes:
            after = k >= since and not held
            jacobian[k, 7] = gain_out * model if after else 0.0
            jacobian[k, 9] = 1.0 if after else 0.0
            jacobian[k, 8] = 0.0 if held else -gain_out * np.sum(moved_by) / strands
            jacobian[k, 10] = 0.0 if held else -gain_out * np.sum(moved) / strands
    if slow:
        _low_passed(y, p[LAG], given[0], left, jacobian)


@njit(cache=True, nogil=True)
def _strands(spread: float, strands: int) -> tuple[Array, Array]:
    """Return the friction of every strand over their mean, and its derivatives by the spread."""
    if strands == 1:
        return np.ones(1), np.zeros(1)
    ratio = np.exp(spread * STRANDS)
    ratio /= np.mean(ratio)
    return ratio, ratio * (STRANDS - np.mean(ratio * STRANDS))


@njit(cache=True, nogil=True)
def _low_passed(y: Array, lag: float, start: float, left: Array, jacobian: Array) -> None:
    """Put a low-pass of first order, ``lag`` the logarithm of its time constant (samples), behind a model that was taken from the output."""
    tau = math.exp(lag)
    keep = math.exp(-1.0 / tau)
    state, by_lag = start, 0.0
    for k in range(y.size):
        v = y[k] - left[k]
        by_lag = keep * by_lag + keep / tau * (state - v)
        state = keep * state + (1.0 - keep) * v
        left[k] = y[k] - state
        for j in range(STEADY):
            before = jacobian[k - 1, j] if k > 0 else 0.0
            jacobian[k, j] = keep * before + (1.0 - keep) * jacobian[k, j]
        jacobian[k, LAG] = by_lag


@njit(cache=True, nogil=True)
def _cost(left: Array, limit: float) -> float:
    total = 0.0
    for v in left:
        a = abs(v)
        total += 0.5 * a * a if a <= limit else limit * (a - 0.5 * limit)
    return total


@njit(cache=True, nogil=True)
def _try(x: Array, y: Array, fast: Array, p: Array, given: Array, floor: float) -> float:
    """Return what a first guess leaves: the mean of what is left, single samples cut off."""
    left = np.empty(x.size)
    _residual(x, y, fast, p, given, left, np.empty((x.size, PARAMETERS)))
    known = np.abs(left[~np.isnan(y)])
    return float(np.mean(np.minimum(known, max(3.0 * np.median(known), floor))))


# long: one descent, kept in one compiled loop because each of its steps takes less than a call from outside
@njit(cache=True, nogil=True)
def _descend(
    x: Array, y: Array, fast: Array, free: NDArray[np.int64], first: Array, given: Array, floor: float, steps: int
) -> tuple[Array, float]:
    """Levenberg-Marquardt on Huber's loss over the free parameters; constant friction and n theta stay positive."""
    n, m = x.size, free.size
    left, jacobian, trial_left, trial_jacobian = np.empty(n), np.empty((n, PARAMETERS)), np.empty(n), np.empty((n, PARAMETERS))
    p = first.copy()
    _residual(x, y, fast, p, given, left, jacobian)
    known = ~np.isnan(y)
    for _ in range(2):
        limit = HUBER * max(1.4826 * np.median(np.abs(left[known])), floor)
        cost = _cost(left, limit)
        damping = 1e-3
        for _ in range(steps):
            normal, gradient = np.zeros((m, m)), np.zeros(m)
            for k in range(n):
                w = min(1.0, limit / max(abs(left[k]), 1e-300))
                for i in range(m):
                    a = w * jacobian[k, free[i]]
                    gradient[i] += a * left[k]
                    for j in range(i + 1):
                        normal[i, j] += a * jacobian[k, free[j]]
            trace = 0.0
            for i in range(m):
                trace += normal[i, i]
                for j in range(i):
                    normal[j, i] = normal[i, j]
            for i in range(m):
                normal[i, i] += damping * normal[i, i] + 1e-9 * trace + 1e-200
            step = np.linalg.solve(normal, gradient)
            trial = p.copy()
            for i in range(m):
                trial[free[i]] += step[i]
            trial[0] = min(max(trial[0], 0.0), 4.0)
            trial[1] = min(max(trial[1], -12.0), 12.0)
            trial[2] = max(trial[2], 0.0)
            trial[5] = min(max(trial[5], -1.0), 3.0)
            if first[SPREAD] > 0.0:
                trial[SPREAD] = min(max(trial[SPREAD], 1e-3), MOST_SPREAD)
            trial[7] = min(max(trial[7], -5.0), 5.0)
            trial[8] = min(max(trial[8], -5.0), 5.0)
            trial[LAG] = min(max(trial[LAG], FASTEST), SLOWEST)
            _residual(x, y, fast, trial, given, trial_left, trial_jacobian)
            tried = _cost(trial_left, limit)
            if tried < cost:
                done = cost - tried < 1e-4 * cost
                p, cost = trial, tried
                left, trial_left = trial_left, left
                jacobian, trial_jacobian = trial_jacobian, jacobian
                damping = max(0.2 * damping, 1e-9)
                if done:
                    break
            else:
                damping *= 8.0
                if damping > 1e5:
                    break
    return p, math.sqrt(np.sum(left**2) / max(1, np.count_nonzero(known)))


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
    floor = max(noise[1], 1e-4 * float(np.ptp(y)))
    friction = best_fit(x, y, FRICTION, floor, play)
    found = Causes(math.hypot(noise[1], math.exp(-friction.wrap) * noise[0]), friction, *[UNKNOWN] * 8)
    if found.enough:
        return found
    bundle = best_fit(x, y, bundled(FRICTION), floor, play)
    found = replace(found, friction=min(friction, bundle, key=lambda c: c.rms_n), bundled=True)
    if found.enough:
        return found
    found = replace(
        found,
        gain=best_fit(x, y, found.freed(GAIN), floor, play),
        zero_in=best_fit(x, y, found.freed(ZERO_IN), floor, play),
        zero_out=best_fit(x, y, found.freed(ZERO_OUT), floor, play),
        moved=_moved(time_s, x, y, floor, play, found),
        slow=_slow(time_s, x, y, floor, found),
        creep=best_fit(x, y, found.freed(CREEP), floor, play),
        reversed=best_fit(np.ascontiguousarray(x[::-1]), np.ascontiguousarray(y[::-1]), found.freed(GAIN), floor),
    )
    taken = (found.zero_in, found.zero_out, found.moved, found.slow, found.creep, found.reversed)
    return replace(found, speed=_by_speed(time_s, x, y, floor, play, found)) if any(found.holds(c.rms_n) for c in taken) else found


def _by_speed(time_s: Array, x: Array, y: Array, floor: float, play: PlayFit, found: Causes) -> Cause:
    """Return what friction that changes with speed leaves; of the speed at which it has changed two are tried."""
    n = SPEED_OVER
    smooth = np.convolve(np.pad(x, n // 2, mode="edge"), np.full(n, 1.0 / n), "valid")
    speed = np.abs(np.gradient(smooth, time_s))
    scales = [max(float(np.quantile(speed, part)), 1e-3 * float(speed.max()), 1e-300) for part in SLOWER]
    return min((best_fit(x, y, found.freed(SPEED), floor, play, -np.expm1(-speed / scale)) for scale in scales), key=lambda c: c.rms_n)


def _moved(time_s: Array, x: Array, y: Array, floor: float, play: PlayFit, found: Causes) -> Cause:
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
        return best_fit(x[inside][::stride], moved[::stride], found.freed(GAIN), floor)

    period = float(np.median(np.diff(time_s)))
    best, step = play.delay_s, max(DELAY_STEP * abs(play.delay_s), period)
    left = {best: fit(best, every).rms_n}
    while step > 0.25 * period and step > DELAY_SHARE * abs(best) and math.isfinite(left[best]):
        for delay in (best - step, best + step):
            if delay not in left:
                left[delay] = fit(delay, every).rms_n
        nearest = min((d for d in left if math.isfinite(left[d])), key=lambda d: left[d])
        best, step = nearest, (step if nearest != best else 0.5 * step)
    return replace(fit(best, 1), size=best)


def _slow(time_s: Array, x: Array, y: Array, floor: float, found: Causes) -> Cause:
    """Return what is left of an output behind a low-pass of its own, whose time constant (s) is the ``size``."""
    period = float(np.median(np.diff(time_s)))
    slow = best_fit(x, y, found.freed(SLOW), floor, behind=Behind(lags=tuple(math.log(s / period) for s in SLOW_S)))
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
    fast = np.zeros(len(x)) if speed is None else speed
    which, begins = np.array(free, np.int64), len(x) if behind.since is None else behind.since
    slip = free[-1]
    given = np.array([float(np.median(y[~np.isnan(y)][:3])), begins, behind.most_n, float(bool(behind.lags))])
    guesses = [_guess(wrap, free) for wrap in STARTS]
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
        guesses.append(_guess(min(wrap, 2.0), free))
        guesses[-1][slip] = likely.get(slip, 0.0)
    guesses.sort(key=lambda p: _try(x, y, fast, p, given, floor))
    found = [_descend(x, y, fast, which, p, given, floor, STEPS) for p in guesses[:TRIED]]
    p, rms = min(found, key=lambda f: f[1])
    left = np.empty(len(x))
    # what is left of nothing is the model, begun where the output began
    _residual(x, np.zeros(len(x)), fast, p, given, left, np.empty((len(x), PARAMETERS)))
    return Cause(float(p[0]), float(p[slip]), float(rms)), -left


def _guess(wrap: float, free: tuple[int, ...]) -> Array:
    """Return a first guess of all parameters that holds n theta, and a spread where that is free."""
    p = np.zeros(PARAMETERS)
    p[0], p[SPREAD] = wrap, FIRST_SPREAD if SPREAD in free else 0.0
    return p


def _level(x: Array, y: Array, slip: int, since: int) -> float:
    """Return the size of a slip that middle levels show: friction of both directions leaves them alike, a slip does not."""
    a, b = float(np.median(x)), float(np.nanmedian(y))
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

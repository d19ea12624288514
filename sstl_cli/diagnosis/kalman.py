"""Kernels of the innovations filter: its gains, which follow the phases, and its pass over residuals and columns.

What the states stand for is written in ``whitening``. A line that is pulled is at the larger one of what it holds and what its
input allows, a released one at the smaller one; where the model breaks away, the true line need not, or has already, if it
holds more or less than the model does. Which of the two it is at follows from the readings before, as far as it is known: the
filter slides by as much as that is likely, and its mean and variance are those of the larger one of two normals (Clark 1961).

A line that jumps rests between its jumps while the model slides on. It lies about the model's mean by the scatter of its jumps
when it lets go: that it rests for a step has the probability that a normal so wide leaves for being further off, given how far off it
is. How readily it stays, and comes to rest once it slides, the steps before tell as well (Krichevsky and Trofimov 1981). The likelier of
resting and sliding is taken, at the cost of saying which.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.diagnosis.slides import MOSTLY
from sstl_cli.diagnosis.smoother import LAW, MOVES
from sstl_cli.diagnosis.smoother import STATES as ERRORS

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Places = NDArray[np.intp]
# error of the input, what the line holds of it, coloured noise of the output's sensor
STATES, HELD_AT, OWN_AT = ERRORS + 2, ERRORS, ERRORS + 1
# columns of the law of the error: the last state kept, its weight in the mean, what is new in it, in both, in the mean, and by how much
# the end of a step differs from its mean
STATE_KEPT, MEAN_KEPT, STATE_NEW, BOTH_FROM, BOTH_NEW, MEAN_NEW, TURN = 15, 19, 29, 30, 33, LAW - 2, LAW - 1
# beyond so many standard deviations of their difference the smaller one of two normals is no more the larger one
SURE = 8.0
# a probability of nothing
NEVER = float(np.finfo(np.float64).tiny)

# columns of the phases, and of the coloured noise of the output's sensor
SLIDE, LEFT, GAIN, DOUBT, JUMPS, STEP, ON_AVERAGE, AHEAD, STEEP = range(9)
DECAY, FRESH, SHOWN, BOTH, MEAN = range(5)
# the phase of a line at rest
REST = np.zeros(STEEP + 1)
# of the input's error as it enters: mean, variance, covariances with what is held and with the sensor's noise; means and covariances of these
Known = tuple[tuple[float, float, float, float], Array, Array]


# long: one pass over the samples, whose state is what the next sample starts from
@njit(cache=True, nogil=True, error_model="numpy")
def gains(
    phases: Array, law: Array, own: Array, white_n: Array, keep: Mask, first: Mask, start: Array, readings: tuple[Array, Array]
) -> tuple[Array, Array, float, Array, Array, Places]:
    """Return the gains on unit innovations (n, 6), one over the innovations' standard deviations (0 where masked), log det, and what else there is.

    State: error of the input (four numbers), what the line holds of it (4), coloured noise of the output's sensor (5); x is its
    mean, p and q are its covariances before and after a step. Then come, of shape (n,), what of the log determinant is beyond the standard
    deviations; the shift (N), what breakaways are expected to leave of the residual; and the place of each step: the one at which the
    line last was on the model's, where it is at rest, else its own.

    Parameters
    ----------
    phases, law, own : ndarray, shape (n, 9), (n, 36) and (n, 5)
        Columns of ``Phases``, law of the input's error, columns of ``Own`` (see whitening). Phases become those of the true line
        as far as they are known.
    readings : tuple of ndarray, shapes (n,) and (n,) or (0,)
        What the model leaves (N), which tells by how much the line holds another output; and the output (N) of a line that may come
        to rest between jumps, empty where none does.
    """
    n, (residual, output) = len(phases), readings
    k_out, scale, log_det, product, shift, held_shift = np.zeros((n, STATES)), np.zeros(n), 0.0, 1.0, np.zeros(n), 0.0
    p, q, m = np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros((ERRORS, STATES))
    e, z, x = np.zeros(STATES), np.zeros(STATES), np.zeros(STATES)
    beyond, place, counts = np.zeros(n), np.arange(n), np.full((2, 2), 0.5)
    rests, way = False, 0.0
    for t in range(n):
        row, decay, shown, bent, seen, turned = law[t], own[t, DECAY], own[t, SHOWN], 0.0, 0.0, 0.0
        breaks, slides = not math.isnan(phases[t, STEP]), phases[t, LEFT] > MOSTLY
        if first[t]:
            p[:, HELD_AT:] = 0.0
            x[HELD_AT:], held_shift, rests, way = 0.0, 0.0, False, 0.0
            if breaks:
                p[HELD_AT, HELD_AT] = start[t]
        _moved(p, row, m, e)
        entering = row[16] * e[0] + row[17] * e[1] + row[18] * e[2] + row[19] * e[3] + row[MEAN_NEW]
        expected = row[16] * x[0] + row[17] * x[1] + row[18] * x[2] + row[19] * x[3]
        if rests and breaks and not slides:
            # the input has turned: what stays is held, by as much as it is off the model there
            x[HELD_AT], held_shift, rests = _held_on(readings, (t, place[t - 1]), x[HELD_AT], held_shift)
        if breaks and not rests:
            bent, seen, turned = _broken(phases[t], (x[HELD_AT], p[HELD_AT, HELD_AT]), (expected, entering), e[HELD_AT])
        if output.size and breaks and slides and keep[t] and not first[t]:
            known = (expected, entering, e[HELD_AT], e[OWN_AT]), x[HELD_AT:], p[HELD_AT:, HELD_AT:]
            noise, at, broken = (shown, own[t, MEAN] + white_n[t] ** 2, law[t - 1, TURN]), (t, place[t - 1]), (bent, seen, turned)
            rests, beyond[t], (bent, seen, turned) = _at_rest(phases, at, (rests, way), counts, readings, known, noise, broken)
        way = (math.copysign(1.0, phases[t, STEP]) if breaks else way) if slides else 0.0
        if rests:
            phases[t, :STEP], place[t], bent, turned, seen = 0.0, place[t - 1], 0.0, 0.0, output[place[t - 1]] - output[t]
        slide, left, gain = phases[t, SLIDE], phases[t, LEFT], phases[t, GAIN]
        # how the mean over the step mixes what was held and what enters, beside how its end does
        hold, follows, rest, enters = 1.0 - left, left * gain, 1.0 - slide, slide * gain
        _entered(q, z, m, row, (follows, hold, decay), (enters, rest, shown))
        if first[t] and not breaks:
            # the output before the first sample is what was read there, or where the input holds it
            p[HELD_AT, HELD_AT] = start[t] + gain**2 * entering
        slip = turned + (_slipped(phases[t]) if first[t] else _left_behind(phases[t - 1], phases[t], law[t - 1, TURN]))
        q[HELD_AT, HELD_AT] = follows * follows * entering + 2.0 * follows * hold * e[HELD_AT] + hold * hold * p[HELD_AT, HELD_AT] + slip
        q[HELD_AT, OWN_AT] = decay * (follows * e[OWN_AT] + hold * p[HELD_AT, OWN_AT])
        q[OWN_AT, OWN_AT] = decay * decay * p[OWN_AT, OWN_AT] + own[t, FRESH]
        shift[t], held_shift = rest * held_shift + seen, hold * held_shift + bent
        new = residual[place[t]] - enters * expected - rest * x[HELD_AT] - seen - shown * x[OWN_AT] if keep[t] else 0.0
        x[HELD_AT], x[OWN_AT] = follows * expected + hold * x[HELD_AT] + bent, decay * x[OWN_AT]
        _error_moves_on(x, row)
        if keep[t]:
            var = _read(z, p, e, entering, (follows, hold, decay), (enters, rest, shown), own[t], slip) + white_n[t] ** 2
            scale[t] = 1.0 / math.sqrt(var)
            # a logarithm of a product instead of one a sample
            product *= var
            if not 1e-100 < product < 1e100:
                log_det += math.log(product)
                product = 1.0
        _learned(x, p, q, z, scale[t], new)
        k_out[t] = z
    return k_out, scale, log_det + math.log(product) + float(np.sum(beyond)), beyond, shift, place


@njit(cache=True, nogil=True, inline="always")
def _held_on(readings: tuple[Array, Array], at: tuple[int, int], held: float, shift: float) -> tuple[float, float, bool]:
    """Return what a line that rested holds beyond the model (N) at the step ``at`` which the model holds, the same of its shift, and False."""
    (residual, output), (now, place) = readings, at
    off = output[place] - residual[place] - output[now] + residual[now]
    return held + off, shift + off, False


@njit(cache=True, nogil=True)
def _at_rest(
    phases: Array,
    at: tuple[int, int],
    stood: tuple[bool, float],
    counts: Array,
    readings: tuple[Array, Array],
    known: Known,
    noise: tuple[float, float, float],
    broken: tuple[float, float, float],
) -> tuple[bool, float, tuple[float, float, float]]:
    """Return whether a line that jumps is likelier at rest where the model slides, twice what it costs (nats) to say so, and how it breaks away.

    ``at`` are the step and the place of the one before, ``stood`` whether the line rested in that, and which way the model slid;
    ``noise`` has the share that the sensor's slow noise before has in the reading, the variance of what is new in that, and what turns
    by at the end of a slide; ``broken`` is what :func:`_broken` makes of the step. A line that surely holds there may as well stay where
    it is, or move on to the model.
    """
    (t, held_at), (rested, way), (residual, output) = at, stood, readings
    phase, before, (shown, noise_n2, turn) = phases[t], phases[t - 1], noise
    rested = rested or phase[LEFT] == 0.0
    bent, seen, turned = (0.0, 0.0, 0.0) if rested else broken
    ahead = math.copysign(1.0, phase[STEP])
    row = 1 if rested or way != ahead else 0
    level = output[held_at] - residual[held_at] + known[1][0]
    far, near = ahead * (output[t] - residual[t] - level), ahead * (output[t - 1] - residual[t - 1] - level)
    stays = counts[row, 1] / (counts[row, 0] + counts[row, 1]) * _further(far, near, phase[JUMPS])
    if rested:
        phase[SLIDE] = phase[LEFT] = 1.0
    slid = _cost(phase, known, shown, residual[t] - seen, turned + _left_behind(before, phase, turn) + noise_n2)
    still = before[SLIDE] * before[GAIN] ** 2 * turn + noise_n2
    resting = _cost(REST, known, shown, output[t] - output[held_at] + residual[held_at], still)
    slides_on, rests_on = -2.0 * math.log(max(1.0 - stays, NEVER)), -2.0 * math.log(max(stays, NEVER))
    rests = resting + rests_on < slid + slides_on
    counts[row, 1 if rests else 0] += 1.0
    return rests, rests_on if rests else slides_on, (bent, seen, turned)


@njit(cache=True, nogil=True, inline="always")
def _cost(phase: Array, known: Known, shown: float, residual: float, more_n2: float) -> float:
    """Return twice the cost (nats) of a reading; ``known`` are mean, variance and covariances of what enters, and of what is held."""
    enters, rest = phase[SLIDE] * phase[GAIN], 1.0 - phase[SLIDE]
    (expected, entering, with_held, with_own), x, p = known
    var = enters * enters * entering + 2.0 * enters * rest * with_held + rest * rest * p[0, 0] + more_n2
    var += 2.0 * shown * (enters * with_own + rest * p[0, 1]) + shown * shown * p[1, 1]
    new = residual - enters * expected - rest * x[0] - shown * x[1]
    return float(new * new / var + math.log(var))


@njit(cache=True, nogil=True, inline="always")
def _further(far: float, near: float, spread: float) -> float:
    """Return the probability that a normal number of a spread exceeds ``far`` where it exceeds ``near``."""
    if far <= near:
        return 1.0
    if spread <= 0.0:
        return 0.0
    beyond = math.erfc(near / spread / math.sqrt(2.0))
    return math.erfc(far / spread / math.sqrt(2.0)) / beyond if beyond > 0.0 else 0.0


@njit(cache=True, nogil=True)
def _broken(phase: Array, held: tuple[float, float], entering: tuple[float, float], both: float) -> tuple[float, float, float]:
    """Set the share by which the true line slides; return what its output is beyond what it is by that share (N), and the variance of that.

    The first is at the end of the step, the second on average over it.
    ``held`` and ``entering`` are mean and variance of the errors of what is held and of the input, ``both`` is their covariance.
    """
    step, ahead, gain = phase[STEP], phase[AHEAD], phase[STEEP]
    # what is held falls behind a line that moves on; before that the line lies the other way, beyond what is held
    way = 1.0 if step - ahead > 0.0 else -1.0
    a, b = way * (held[0] - step), way * (ahead + gain * entering[0])
    va, vb, cov = held[1], gain * gain * entering[1], gain * both
    apart = math.sqrt(max(va + vb - 2.0 * cov, 1e-300))
    at = min(max((a - b) / apart, -SURE), SURE)
    holds = 0.0 if at == -SURE else 1.0 if at == SURE else 0.5 * math.erfc(-at / math.sqrt(2.0))
    if holds == 0.0 and phase[LEFT] > 0.0:
        return 0.0, 0.0, 0.0
    slides = 1.0 - holds
    phase[SLIDE], phase[LEFT] = slides * phase[SLIDE] if phase[SLIDE] > 0.0 else slides, slides
    if slides == 0.0:
        return -step, -phase[ON_AVERAGE], 0.0
    # of a hold that may have ended it is known by how much
    phase[GAIN], phase[DOUBT] = gain, 0.0
    more = apart * math.exp(-0.5 * at * at) / math.sqrt(2.0 * math.pi) if holds > 0.0 else 0.0
    mean = holds * a + slides * b + more
    second = holds * (a * a + va) + slides * (b * b + vb) + (a + b) * more
    linear = holds * holds * va + slides * slides * vb + 2.0 * holds * slides * cov
    bent = way * mean - holds * held[0] - slides * gain * entering[0]
    # of a step that the line holds through, the model has come less far on average than at its end
    return bent, bent + holds * (step - phase[ON_AVERAGE]), max(second - mean * mean - linear, 0.0)


@njit(cache=True, nogil=True, inline="always")
def _error_moves_on(x: Array, row: Array) -> None:
    """Set the mean of the input's error after a step."""
    x0, x1, x2, x3 = x[0], x[1], x[2], x[3]
    for i in range(ERRORS):
        x[i] = row[4 * i] * x0 + row[4 * i + 1] * x1 + row[4 * i + 2] * x2 + row[4 * i + 3] * x3


@njit(cache=True, nogil=True, inline="always")
def _moved(p: Array, row: Array, m: Array, e: Array) -> None:
    """Set the transition times the covariance of the input's error, and that of its mean over the step with the state before."""
    for j in range(STATES):
        c0, c1, c2, c3 = p[0, j], p[1, j], p[2, j], p[3, j]
        for i in range(ERRORS):
            m[i, j] = row[4 * i] * c0 + row[4 * i + 1] * c1 + row[4 * i + 2] * c2 + row[4 * i + 3] * c3
        e[j] = row[16] * c0 + row[17] * c1 + row[18] * c2 + row[19] * c3


@njit(cache=True, nogil=True, inline="always")
def _entered(q: Array, z: Array, m: Array, row: Array, end: tuple[float, float, float], mean: tuple[float, float, float]) -> None:
    """Set the covariances of the input's error after a step: with itself, with what is held and the sensor's noise, with the reading.

    ``end`` and ``mean`` are the shares of the input, of what was held and of the sensor's noise at the end of the step and in its mean.
    """
    at = MOVES
    for i in range(ERRORS):
        m0, m1, m2, m3 = m[i, 0], m[i, 1], m[i, 2], m[i, 3]
        for j in range(i, ERRORS):
            q[i, j] = m0 * row[4 * j] + m1 * row[4 * j + 1] + m2 * row[4 * j + 2] + m3 * row[4 * j + 3] + row[at]
            at += 1
        with_mean = m0 * row[16] + m1 * row[17] + m2 * row[18] + m3 * row[19] + row[BOTH_FROM + i]
        q[i, HELD_AT] = end[0] * with_mean + end[1] * m[i, HELD_AT]
        q[i, OWN_AT] = end[2] * m[i, OWN_AT]
        # of the sensor's own noise a step shows the mean
        z[i] = mean[0] * with_mean + mean[1] * m[i, HELD_AT] + mean[2] * m[i, OWN_AT]


@njit(cache=True, nogil=True, inline="always")
def _read(
    z: Array,
    p: Array,
    e: Array,
    entering: float,
    end: tuple[float, float, float],
    mean: tuple[float, float, float],
    own: Array,
    slip: float,
) -> float:
    """Set the covariances of what is held and of the sensor's noise after a step with its reading; return the variance of that without white noise.

    ``end`` and ``mean`` are the shares of the input, of what was held and of the sensor's noise at the end of the step and in its mean.
    """
    (follows, hold, decay), (enters, rest, shown) = end, mean
    held, own_n2, both, with_held, with_own = p[HELD_AT, HELD_AT], p[OWN_AT, OWN_AT], p[HELD_AT, OWN_AT], e[HELD_AT], e[OWN_AT]
    shows = enters * with_own + rest * both
    z[HELD_AT] = enters * follows * entering + (enters * hold + rest * follows) * with_held + rest * hold * held + slip
    z[HELD_AT] += shown * (follows * with_own + hold * both)
    z[OWN_AT] = decay * (shows + shown * own_n2) + own[BOTH]
    var = enters * enters * entering + 2.0 * enters * rest * with_held + rest * rest * held + slip
    return float(var + 2.0 * shown * shows + shown * shown * own_n2 + own[MEAN])


@njit(cache=True, nogil=True, inline="always")
def _learned(x: Array, p: Array, q: Array, z: Array, scale: float, new: float) -> None:
    """Set mean and covariance after a reading, and the gain on its unit innovation, from the covariances with it; where there is none (scale 0) they only go on."""
    for i in range(STATES):
        z[i] *= scale
    for i in range(STATES):
        x[i] += z[i] * scale * new
        for j in range(i, STATES):
            p[i, j] = p[j, i] = q[i, j] - z[i] * z[j]


@njit(cache=True, nogil=True, inline="always")
def _slipped(phase: Array) -> float:
    return float(phase[DOUBT] ** 2 + phase[JUMPS] ** 2)


@njit(cache=True, nogil=True, inline="always")
def _left_behind(before: Array, now: Array, turn: float) -> float:
    """Return the variance (N^2) of what a slip that may or may not have happened leaves until the next slide, and a slide that ends."""
    slip = max(_slipped(now) - (1.0 - now[SLIDE]) ** 2 * _slipped(before), 0.0)
    if now[SLIDE] < before[SLIDE]:
        # a line holds the error with which its slide has ended, not that of the mean over the step
        slip += (1.0 - now[SLIDE] / before[SLIDE]) * before[GAIN] ** 2 * turn
    return float(slip)


@njit(cache=True, nogil=True)
def filtered(x: Array, moves: Array, own: Array, weights: Array, scale: Array, phases: Array, first: Mask) -> Array:
    """Return innovations over their standard deviations of every column, shape (n, k)."""
    n, k = x.shape
    out = np.zeros((n, k))
    state = np.zeros((STATES, k))
    for t in range(n):
        if first[t]:
            state[HELD_AT:, :] = 0.0
        row, u = moves[t], weights[t]
        t00, t01, t02, t03, t10, t11, t12, t13 = row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7]
        t20, t21, t22, t23, t30, t31, t32, t33 = row[8], row[9], row[10], row[11], row[12], row[13], row[14], row[15]
        f0, f1, f2, f3 = row[16], row[17], row[18], row[19]
        slide, left, gain, d, g, s = phases[t, SLIDE], phases[t, LEFT], phases[t, GAIN], own[t, DECAY], own[t, SHOWN], scale[t]
        hold, f, rest, enters = 1.0 - left, left * gain, 1.0 - slide, slide * gain
        u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
        for j in range(k):
            a0, a1, a2, a3 = state[0, j], state[1, j], state[2, j], state[3, j]
            e0, e1 = t00 * a0 + t01 * a1 + t02 * a2 + t03 * a3, t10 * a0 + t11 * a1 + t12 * a2 + t13 * a3
            e2, e3 = t20 * a0 + t21 * a1 + t22 * a2 + t23 * a3, t30 * a0 + t31 * a1 + t32 * a2 + t33 * a3
            new, a4, a5 = f0 * a0 + f1 * a1 + f2 * a2 + f3 * a3, state[4, j], state[5, j]
            e4 = f * new + hold * a4
            # 0 where masked: the state is only moved on
            v = s * (x[t, j] - enters * new - rest * a4 - g * a5) if s > 0.0 else 0.0
            out[t, j] = v
            state[0, j], state[1, j], state[2, j], state[3, j] = e0 + u0 * v, e1 + u1 * v, e2 + u2 * v, e3 + u3 * v
            state[4, j], state[5, j] = e4 + u4 * v, d * a5 + u5 * v
    return out

"""The play operator of Eqs. (3) and (5) fitted to a recording or a part of it, with the output's delay and clock drift.

Unlike the lines of ``segment_run`` it needs no phases, so that it also judges recordings whose phases make no sense.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median, spread

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
ITERATIONS = 10
HUBER = 1.5
# first guesses of the delay, as parts of the recording; residual over noise from which on they are tried, and what they must gain
DELAYS, GUESSED, BETTER = (-0.16, -0.08, -0.04, -0.012, 0.012, 0.04, 0.08, 0.16), 3.0, 0.7
# share of the output's variance that must be left for delays of a good part of the recording to be tried, and how large a part
UNEXPLAINED, FARTHEST = 0.1, 0.4
# part of a recording that must still overlap once it is moved in time
LEAST_OVERLAP = 0.5


@dataclass(frozen=True)
class PlayFit:
    """Lines (slopes, biases in N), delay (s, negative where the output leads) and drift (s/s) of the output's clock.

    ``rms_n`` is the residual without a delay, ``delayed_rms_n`` with one, ``drifting_rms_n`` with drift as well;
    ``typical_n`` is what
    its middle half tells (spikes weigh nothing), ``explained`` the share of the output's variance that lines and delay explain;
    ``shares`` are the parts of the samples on the line of pull and on that of release, ``reaches`` the parts of the
    input's span that these lines were seen over.
    """

    gamma_p: float
    beta_p: float
    gamma_r: float
    beta_r: float
    delay_s: float
    delay_se: float
    drift: float
    drift_se: float
    rms_n: float
    delayed_rms_n: float
    drifting_rms_n: float
    typical_n: float
    explained: float
    shares: tuple[float, float]
    reaches: tuple[float, float]


@dataclass(frozen=True)
class _Samples:
    """Time (s), input and output (N), each of shape (n,); ``counts`` tells which readings of the output do (None: all).

    At the samples ``anew`` the play begins again from the output.
    """

    time_s: Array
    x: Array
    y: Array
    counts: Mask | None = None
    anew: tuple[int, ...] = ()

    @cached_property
    def middle(self) -> float:
        """Time (s) at which a drifting clock is right."""
        return 0.5 * float(self.time_s[0] + self.time_s[-1])

    def counted(self, values: Array) -> Array:
        """Return those of the values, shape (n,), that count."""
        return values if self.counts is None else values[self.counts]


@njit(cache=True, nogil=True)
def _play(x: Array, p: Array, start: float) -> tuple[Array, Array]:
    """Return the output of the play operator from ``start`` on, and its derivatives with respect to (Gp, bp, Gr, br)."""
    n = x.size
    y = np.empty(n)
    jacobian = np.zeros((n, 4))
    v = start
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    for k in range(n):
        low, high = p[0] * x[k] + p[1], p[2] * x[k] + p[3]
        if v < low:
            v, s0, s1, s2, s3 = low, x[k], 1.0, 0.0, 0.0
        elif v > high:
            v, s0, s1, s2, s3 = high, 0.0, 0.0, x[k], 1.0
        y[k] = v
        jacobian[k, 0], jacobian[k, 1], jacobian[k, 2], jacobian[k, 3] = s0, s1, s2, s3
    return y, jacobian


def fit_play(time_s: Array, x: Array, y: Array, start: Array, noise_n: float = 0.0, timed: bool = True) -> PlayFit:
    """Return the play operator that explains an output best, in the sense of Huber's loss.

    Parameters
    ----------
    time_s, x, y : ndarray, shape (n,)
        Time in s, input and output in N.
    start : ndarray, shape (4,)
        First guess of (Gp, bp, Gr, br).
    noise_n : float
        Noise of the output (N): where no more than that is left, no drift is looked for.
    timed : bool
        Whether delay and drift are fitted at all.
    """
    s = _Samples(time_s, x, y)
    still, rms = _descend(s, np.concatenate((start, [0.0, 0.0])), 4)
    best, delayed_rms, delay_se = still, rms, float("nan")
    if timed:
        best, delayed_rms = _delayed(s, still, noise_n)
        delay_se = float(_errors(s, best, 5)[4])
    drift, drift_se, drifting_rms = 0.0, float("nan"), delayed_rms
    if timed and delayed_rms > 1.5 * noise_n:
        drifting, drifting_rms = _descend(s, best, 6)
        drift, drift_se = float(drifting[5]), float(_errors(s, drifting, 6)[5])
    power = max(float(np.var(y)), 1e-300)
    late = (y - _model(s, best, 5)[0])[_inside(s, best)]
    shares, reaches = _seen(x, float(y[0]), best)
    return PlayFit(
        gamma_p=float(best[0]),
        beta_p=float(best[1]),
        gamma_r=float(best[2]),
        beta_r=float(best[3]),
        delay_s=float(best[4]),
        delay_se=delay_se,
        drift=drift,
        drift_se=drift_se,
        rms_n=rms,
        delayed_rms_n=delayed_rms,
        drifting_rms_n=drifting_rms,
        typical_n=spread(late),
        explained=1.0 - min(rms, delayed_rms) ** 2 / power,
        shares=shares,
        reaches=reaches,
    )


def line_beside(x: Array, y: Array, start: Array, counts: Mask, anew: tuple[int, ...] = ()) -> tuple[Array, float]:
    """Return the output (N, shape (n,)) of the play that explains best those readings of an output that count, and what it leaves (N RMS).

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Input and output in N.
    start : ndarray, shape (4,)
        First guess of (Gp, bp, Gr, br).
    counts : ndarray, shape (n,)
        Which readings of the output count; one at least.
    anew : tuple of int
        Samples at which the play begins again from the output, as it came there in a way that no input tells.
    """
    s = _Samples(np.arange(float(len(x))), x, y, counts, anew)
    p, rms = _descend(s, np.concatenate((start, [0.0, 0.0])), 4)
    return _passed_on(s, p)[0], rms


def corners(x: tuple[float, float], y: tuple[float, float], theta: float) -> Array:
    """Return lines through the corners of a loop (lowest and highest, N): the top belongs to the pull, the bottom to the release."""
    gain = (y[1] - y[0]) / max(x[1] - x[0], 1e-300) * math.exp(0.5 * theta)
    gp, gr = gain * math.exp(-theta), gain * math.exp(theta)
    return np.array([gp, y[1] - gp * x[1], gr, y[0] - gr * x[0]])


def _delayed(s: _Samples, still: Array, noise_n: float) -> tuple[Array, float]:
    """Return the fit with a delay; where more than noise is left, from several first guesses of it."""
    best, rms = _descend(s, still, 5)
    guesses = [(still, share * float(s.time_s[-1] - s.time_s[0])) for share in DELAYS] if rms > GUESSED * noise_n else []
    if rms**2 > UNEXPLAINED * float(np.var(s.y)):
        # a long delay leaves nothing of the lines fitted without it
        a, b = ((float(low), float(high)) for low, high in (np.quantile(v, [0.005, 0.995]) for v in (s.x, s.y)))
        shifts = _shifts(s) + [guess for _, guess in guesses]
        guesses += [(np.append(corners(a, b, 0.5), [0.0, 0.0]), shift) for shift in shifts]
    for first, guess in guesses:
        start = first.copy()
        start[4] = guess
        found, left = _descend(s, start, 5)
        if left < BETTER * rms:
            best, rms = found, left
    return best, rms


def _shifts(s: _Samples) -> list[float]:
    """Return the delays (s), one either way, with which the output is most like the input, up to 0.4 of the recording."""
    n = len(s.x)
    a, b = s.x - np.mean(s.x), s.y - np.mean(s.y)
    both = np.fft.irfft(np.fft.rfft(b, 2 * n) * np.conj(np.fft.rfft(a, 2 * n)), 2 * n)
    reach = int(FARTHEST * n)
    step = float(s.time_s[-1] - s.time_s[0]) / max(1, n - 1)
    # what is shifted overlaps less
    after, before = (both[1 : reach + 1], both[-1 : -reach - 1 : -1])
    share = 1.0 - np.arange(1, reach + 1) / n
    return [(1 + int(np.argmax(v / share))) * step * sign for v, sign in ((after, 1.0), (before, -1.0))] if reach else []


def _seen(x: Array, start: float, p: Array) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the parts of the samples that move along pull and release, and the parts of the input's span they cover."""
    y, on = _play(x, p[:4], start)
    move = np.diff(x, prepend=x[0])
    # in backlash the output rests and is on neither line
    moved = np.diff(y, prepend=y[0]) != 0.0
    pull, release = moved & (move > 0.0) & (on[:, 1] == 1.0), moved & (move < 0.0) & (on[:, 3] == 1.0)
    span = max(float(np.ptp(x)), 1e-300)
    reach = [float(np.ptp(np.quantile(x[at], [0.02, 0.98]))) / span if at.any() else 0.0 for at in (pull, release)]
    return (float(np.mean(pull)), float(np.mean(release))), (reach[0], reach[1])


def _passed_on(s: _Samples, p: Array) -> tuple[Array, Array]:
    """Return the output of the play on the input's clock, all of it, and its derivatives with respect to the lines."""
    if not s.anew:
        return _play(s.x, p[:4], median(s.y[:3]))
    edges = (0, *s.anew, len(s.x))
    starts = (median(s.y[:3]), *s.y[list(s.anew)].tolist())
    parts = [_play(s.x[a:b], p[:4], start) for a, b, start in zip(edges[:-1], edges[1:], starts, strict=True)]
    return np.concatenate([y for y, _ in parts]), np.concatenate([lines for _, lines in parts])


def _model(s: _Samples, p: Array, free: int) -> tuple[Array, Array]:
    """Return the output and its derivatives with respect to the first ``free`` parameters; what does not count is as measured."""
    y, lines = _passed_on(s, p)
    if free == 4 and p[4] == 0.0:
        return (y, lines) if s.counts is None else (np.where(s.counts, y, s.y), lines * s.counts[:, None])
    known = _inside(s, p)
    return _moved(s.time_s, y, lines, s.y, p, s.middle, known if s.counts is None else known & s.counts, free)


@njit(cache=True, nogil=True)
def _moved(time_s: Array, y: Array, lines: Array, measured: Array, p: Array, middle: float, known: Mask, free: int) -> tuple[Array, Array]:
    """Return output and derivatives on the output's own clock, the derivatives by delay and drift with them."""
    n = len(time_s)
    rate = np.empty(n)
    rate[0] = (y[1] - y[0]) / (time_s[1] - time_s[0])
    rate[-1] = (y[-1] - y[-2]) / (time_s[-1] - time_s[-2])
    for k in range(1, n - 1):
        before, after = time_s[k] - time_s[k - 1], time_s[k + 1] - time_s[k]
        rate[k] = (before**2 * (y[k + 1] - y[k]) + after**2 * (y[k] - y[k - 1])) / (before * after * (before + after))
    moves = p[4] != 0.0 or p[5] != 0.0
    model, columns = np.empty(n), np.zeros((n, max(free, 4)))
    k = 0
    for i in range(n):
        if not known[i]:
            # what belongs to an input that was not recorded says nothing
            model[i] = measured[i]
            continue
        k, part = (k if moves else min(i, n - 2)), (0.0 if i < n - 1 else 1.0)
        if moves:
            # the same shift for all: where the moved clock falls between two samples
            at = time_s[i] - p[4] - p[5] * (time_s[i] - middle)
            while k < n - 2 and time_s[k + 1] < at:
                k += 1
            while k > 0 and time_s[k] >= at:
                k -= 1
            part = min(max((at - time_s[k]) / (time_s[k + 1] - time_s[k]), 0.0), 1.0)
        model[i] = y[k] + part * (y[k + 1] - y[k])
        for j in range(4):
            columns[i, j] = lines[k, j] + part * (lines[k + 1, j] - lines[k, j])
        slope = rate[k] + part * (rate[k + 1] - rate[k])
        if free > 4:
            columns[i, 4] = -slope
        if free > 5:
            columns[i, 5] = -slope * (time_s[i] - middle)
    return model, columns


def _inside(s: _Samples, p: Array) -> Mask:
    """Return which samples of the output, moved in time, still have an input."""
    at = s.time_s - p[4] - p[5] * (s.time_s - s.middle)
    inside = (at >= s.time_s[0]) & (at <= s.time_s[-1])
    return inside if np.count_nonzero(inside) > LEAST_OVERLAP * len(s.time_s) else np.ones(len(s.time_s), np.bool_)


def _descend(s: _Samples, start: Array, free: int) -> tuple[Array, float]:
    """Levenberg-Marquardt on Huber's loss over the first ``free`` parameters; the scale follows the residual once."""
    p = start.copy()
    model, jacobian = _model(s, p, free)
    residual = s.y - model
    for _ in range(2):
        counted = s.counted(residual)
        limit = HUBER * max(spread(counted), 1e-3 * float(np.abs(counted).max()), 1e-300)
        cost, weight = _loss(residual, limit)
        cost /= float(np.mean(_inside(s, p)))
        damping = 1e-3
        for _ in range(ITERATIONS):
            weighted = (jacobian * weight[:, None]).T
            normal, gradient = weighted @ jacobian, weighted @ residual
            scale = np.diag(normal) + 1e-12 * float(np.trace(normal)) + 1e-200
            trial = p.copy()
            trial[:free] += np.linalg.lstsq(normal + damping * np.diag(scale), gradient, rcond=1e-12)[0]
            model, candidate = _model(s, trial, free)
            tried, tried_weight = _loss(s.y - model, limit)
            tried /= float(np.mean(_inside(s, trial)))
            # a step that overflows is no step
            if np.isfinite(tried) and tried < cost:
                done = cost - tried < 1e-3 * cost
                p, jacobian, residual, cost, weight = trial, candidate, s.y - model, tried, tried_weight
                damping = max(0.2 * damping, 1e-9)
                if done:
                    break
            else:
                damping *= 8.0
                if damping > 1e5:
                    break
    inside = _inside(s, p)
    return p, float(np.sqrt(np.mean(residual[inside if s.counts is None else inside & s.counts] ** 2)))


def _loss(residual: Array, limit: float) -> tuple[float, Array]:
    """Return the mean of Huber's loss and the weights of iterated least squares."""
    size = np.abs(residual)
    weight = np.minimum(1.0, limit / np.maximum(size, 1e-300))
    return float(np.mean(np.where(size <= limit, 0.5 * size**2, limit * (size - 0.5 * limit)))), weight


def _errors(s: _Samples, p: Array, free: int) -> Array:
    """Return standard errors of the first ``free`` parameters, widened for residuals that are not independent."""
    model, jacobian = _model(s, p, free)
    residual = s.y - model
    power = float(np.mean(residual**2)) or 1e-300
    lag = float(np.clip(np.mean(residual[1:] * residual[:-1]) / power, 0.0, 0.98))
    normal = jacobian.T @ jacobian
    if not np.isfinite(normal).all() or float(np.abs(normal).max()) > 1e150:
        return np.full(free, np.inf)
    scale = np.sqrt(np.diag(normal))
    scale[scale == 0.0] = 1.0
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-10)
    return np.asarray(np.sqrt(np.maximum(np.diag(inverse), 0.0) * power * (1.0 + lag) / (1.0 - lag)) / scale)

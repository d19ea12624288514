"""The four phases of a loop: reversals of the input, backlash by threshold, propagation after it."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sstl_cli.identification import filtering

Array = NDArray[np.float64]
Codes = NDArray[np.uint8]
PHASE_NAMES = ("PB", "PP", "RB", "RP")
# shares of the range below which thresholds do not go: while slow noise is unknown, and once a fit has shown it
FIRST_FLOOR, FLOOR = 0.02, 0.005


def label_phases(
    time_s: Array,
    tension_in_n: Array,
    tension_out_n: Array,
    cutoff_hz: float | None = None,
    prominence_n: float | None = None,
    delta_bl_n: float | None = None,
) -> Codes:
    """Return the phase of every sample of a continuous recording as a code into ``PHASE_NAMES``.

    Parameters
    ----------
    time_s, tension_in_n, tension_out_n : ndarray, shape (n,)
        Time in s and tensions in N; a non-finite tension is bridged by its neighbours.
    cutoff_hz, prominence_n, delta_bl_n : float, optional
        As in :class:`SegmentOptions`.

    Returns
    -------
    ndarray of uint8, shape (n,)
        0 PB, 1 PP, 2 RB, 3 RP; a hold keeps the phase it began in.
    """
    n = len(time_s)
    if n < 4:
        return np.zeros(n, np.uint8)
    x, y = _finite(tension_in_n), _finite(tension_out_n)
    dt = filtering.sampling(time_s)
    sd_in, sd_out = filtering.noise_sd(x), filtering.noise_sd(y)
    x, y = filtering.bridged(x, sd_in, float(np.ptp(x))), filtering.bridged(y, sd_out, float(np.ptp(y)))
    cutoff = cutoff_hz or filtering.default_cutoff(x, dt, sd_in)
    xf, yf = filtering.low_pass(x, y, cutoff, dt)
    left_in, left_out = filtering.filtered_sd(sd_in, cutoff, dt), filtering.filtered_sd(sd_out, cutoff, dt)
    span_in, span_out = float(np.ptp(xf)), float(np.ptp(yf))
    prominence = prominence_n or default_prominence(span_in, left_in)
    delta = delta_bl_n or default_delta(span_out, left_out)
    points, direction = turning_points(xf, prominence, default_tie(span_in, left_in, prominence))
    codes, _, _ = split(xf, yf, points, direction, Rules(delta, left_in, prominence, Motion(xf, cutoff, dt)).array(), NO_LINES)
    return codes


def default_prominence(span: float, sd: float, floor: float = FIRST_FLOOR) -> float:
    """Return a prominence (N) that noise of standard deviation ``sd`` does not reach, for an input of this span (N)."""
    return max(10.0 * sd, floor * span, 1e-12)


def default_tie(span: float, sd: float, prominence: float) -> float:
    """Return how far (N) a sample may lie from the extreme and still belong to the turn (the filter overshoots)."""
    return min(max(3.0 * sd, 0.0025 * span), 0.5 * prominence)


def default_delta(span: float, sd: float, floor: float = FIRST_FLOOR) -> float:
    """Return a backlash threshold (N) that noise of standard deviation ``sd`` does not reach, for an output of this span (N)."""
    return max(8.0 * sd, floor * span, 1e-12)


class Motion:
    """What the thresholds need of a filtered input: its span (N), its usual fastest rate (N a sample), and its clock."""

    def __init__(self, xf: Array, cutoff_hz: float, dt_s: float) -> None:
        self.samples, self.cutoff_hz, self.dt_s = len(xf), cutoff_hz, dt_s
        self.span = float(np.ptp(xf))
        every = max(1, len(xf) // 2048)
        steps = np.sort(np.abs(np.diff(xf[::every])))
        # the quantile lies between two steps, as numpy takes it
        place = 0.95 * (len(steps) - 1)
        self.rate = (
            float(np.interp(place, (int(place), int(place) + 1), (steps[int(place)], steps[min(int(place) + 1, len(steps) - 1)]))) / every
        )


class Rules:
    """Thresholds of the split in samples and N, packed for the compiled kernel."""

    def __init__(self, delta: float, sd_in: float, prominence: float, motion: Motion) -> None:
        self.delta = delta
        cutoff_hz, dt_s = motion.cutoff_hz, motion.dt_s
        # the filter smears a corner over about a third of the cut-off's period
        self.guard = math.ceil(0.3 / (cutoff_hz * dt_s) - 1e-6) if cutoff_hz * dt_s < 0.45 else 0
        self.retreat = 0.5 * prominence
        self.hold_band = max(4.0 * sd_in, 1e-4 * motion.span)
        crossing = 2.0 * self.hold_band / motion.rate if motion.rate > 0 else float(motion.samples)
        self.hold = max(3.0, math.ceil(5.0 * crossing), math.ceil(0.2 / dt_s - 1e-6) if dt_s < 0.05 else 3.0)
        self.margin = (0.0, 0.0)

    def array(self) -> Array:
        """Return (delta, guard, retreat, hold band, hold length, margin of pull, margin of release)."""
        return np.array([self.delta, self.guard, self.retreat, self.hold_band, self.hold, *self.margin])


NO_LINES = np.full(4, np.nan)


@njit(cache=True, nogil=True)
def turning_points(xf: Array, prominence: float, tie: float) -> tuple[NDArray[np.int64], int]:
    """Return indices that bound the monotonic segments and the direction of the first (+1 pull, -1 release, 0 none).

    A reversal stands at the last sample within ``tie`` of the extreme, so that a hold belongs to the
    segment that led to it.
    """
    n = xf.size
    points = np.empty(n + 2, np.int64)
    points[0] = 0
    high, low = xf[0], xf[0]
    at_high, at_low = 0, 0
    first, count, k = 0, 1, 0
    # what comes before the first reversal is less than the prominence: it joins the first segment
    while first == 0 and k < n:
        v = xf[k]
        high, low = max(high, v), min(low, v)
        if v >= high - tie:
            at_high = k
        if v <= low + tie:
            at_low = k
        if v < high - prominence:
            first, points[0] = -1, at_high
        elif v > low + prominence:
            first, points[0] = 1, at_low
        else:
            k += 1
    sign = first
    while k < n:
        # a fall is a rise of the other sign; the limits change with the extreme only, so that a sample need not wait for the one before
        extreme = sign * xf[k]
        near, far, at = extreme - tie, extreme - prominence, k
        k += 1
        while k < n:
            v = sign * xf[k]
            if v >= near:
                at = k
                if v > extreme:
                    extreme, near, far = v, v - tie, v - prominence
            elif v < far:
                points[count] = at
                count += 1
                sign = -sign
                break
            k += 1
    points[count] = n - 1
    return points[: count + 1].copy(), first


@njit(cache=True, nogil=True)
def _left(y: Array, sign: int, delta: float) -> tuple[int, int]:
    """Return where the output of a segment leaves its value at the reversal by the threshold, and where that began; 0 where it does not."""
    extreme = sign * y[0]
    for k in range(y.size):
        v = sign * y[k]
        if v < extreme:
            extreme = v
        elif v - extreme > delta:
            start = k
            while start > 0 and sign * y[start - 1] - extreme > 0.3 * delta:
                start -= 1
            return k, start
    return 0, 0


@njit(cache=True, nogil=True)
def _moving(x: Array, use: NDArray[np.int8], band: float, hold: float) -> None:
    """Take out of use where the input holds: it stays within the band for the length of a hold."""
    anchor, last = 0, x.size - 1
    held = x[0]
    for k in range(x.size):
        if abs(x[k] - held) > band or k == last:
            if k - anchor >= hold:
                use[anchor:k] = 0
            anchor = k
            held = x[k]


@njit(cache=True, nogil=True)
def split(
    xf: Array, yf: Array, points: NDArray[np.int64], first: int, rules: Array, lines: Array
) -> tuple[Codes, NDArray[np.int8], NDArray[np.int64]]:
    """Return phase codes, which samples may enter a line, and segments that propagate per direction.

    ``lines`` holds (Gp, bp, Gr, br) where known: then a sample must also lie beyond the point where its
    line leaves the held output, by the margin.
    """
    n = xf.size
    codes = np.zeros(n, np.uint8)
    use = np.zeros(n, np.int8)
    reached = np.zeros(2, np.int64)
    if first == 0:
        return codes, use, reached
    delta, guard, retreat, band, hold = rules[0], int(rules[1]), rules[2], rules[3], rules[4]
    sign = first
    for s in range(points.size - 1):
        a, b = points[s], points[s + 1]
        backlash = 0 if sign > 0 else 2
        begin = 0 if s == 0 else a
        codes[begin : b + 1] = backlash
        left, start = _left(yf[a : b + 1], sign, delta)
        if left > 0:
            codes[a + start : b + 1] = backlash + 1
            d = 0 if sign > 0 else 1
            reached[d] += 1
            level = 0.0
            if start > 0:
                for k in range(a, a + start):
                    level += yf[k]
                level /= start
            else:
                level = yf[a]
            slope, bias, margin = lines[2 * d], lines[2 * d + 1], rules[5 + d]
            if math.isnan(slope):
                slope, bias, margin = 0.0, 0.0, -np.inf
            part = slice(a + left, max(a + left, b + 1 - guard // 2))
            x, used = xf[part], use[part]
            front = sign * xf[a]
            for k in range(min(guard, x.size)):
                front = max(front, sign * x[k])
            far = front - retreat
            for k in range(guard, x.size):
                v = sign * x[k]
                if v > front:
                    front, far = v, v - retreat
                if v >= far and not sign * (slope * x[k] + bias - level) < margin:
                    used[k] = sign
            if x.size:
                _moving(x, used, band, hold)
        sign = -sign
    return codes, use, reached


def _finite(values: Array) -> Array:
    bad = ~np.isfinite(values)
    if not bad.any():
        return np.ascontiguousarray(values, dtype=np.float64)
    good = np.flatnonzero(~bad)
    if good.size == 0:
        return np.zeros(len(values))
    return np.interp(np.arange(len(values)), good, values[good])

"""Two clocks: how much one is ahead of and faster than the other, found from what both recorded."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
MAX_GRID = 1 << 21
WINDOWS = 8
MIN_SAMPLES = 32
MIN_CORRELATION = 0.5
# of what an offset alone leaves, how much may remain with a drift, as in the check of a log; friction's loop stays as it is
REMAINS = 0.5
# samples and offsets that are tried
COMPARED, OFFSETS = 1 << 14, 81


@dataclass(frozen=True)
class ClockReport:
    """Offset and drift of a clock against the reference: ``t_reference = t - offset - drift * (t - origin)``.

    ``offset_s`` and ``drift_ppm`` carry standard errors from the least-squares residuals, ``correlation`` says how
    well the content agrees once they are removed. Without shared content the numbers also hold the lag of the
    transmission itself (hysteresis delays the output), so they are reported and not applied by default, and a drift only where
    ``drift_tells`` it; else it is None.
    """

    reference: str
    clock: str
    offset_s: float | None
    offset_se_s: float | None
    drift_ppm: float | None
    drift_se_ppm: float | None
    correlation: float | None
    origin_s: float
    shared_content: bool
    used: bool = False
    why_not: str = ""

    @property
    def estimated(self) -> bool:
        """Whether the data were enough for an estimate."""
        return self.offset_s is not None

    def applied(self, used: bool) -> ClockReport:
        """Return the report with its statement on whether the estimate was used."""
        return replace(self, used=used)

    def to_reference(self, time: Array) -> Array:
        """Return times of this clock, in seconds of the reference clock."""
        assert self.offset_s is not None and self.drift_ppm is not None
        return np.asarray(time - self.offset_s - self.drift_ppm * 1e-6 * (time - self.origin_s))

    def document(self) -> dict[str, object]:
        """Return the report as plain values."""
        return asdict(self)

    def sentence(self) -> str:
        """Return the report in words."""
        if not self.estimated:
            return f"clock '{self.clock}' against '{self.reference}': not compared ({self.why_not})"
        used = "applied" if self.used else "not applied"
        hint = (
            ""
            if self.shared_content
            else "; not a clock fault where friction delays the output: this holds the lag of the transmission, as no shared content is named"
        )
        drift = "" if self.drift_ppm is None else f"drift {self.drift_ppm:.4g} ppm (se {self.drift_se_ppm:.2g}), "
        return (
            f"clock '{self.clock}' against '{self.reference}': "
            f"offset {self.offset_s:.6g} s (se {self.offset_se_s:.2g}), {drift}"
            f"correlation {self.correlation:.3f}, {used}{hint}"
        )


def on_grid(grid: Array, time: Array, values: Array) -> Array:
    """Return a series interpolated linearly at ``grid`` (s); NaN outside it and where a neighbour is NaN."""
    if len(time) == 0:
        return np.full(len(grid), np.nan)
    return np.asarray(np.interp(grid, time, values, left=np.nan, right=np.nan))


def compare(
    reference: str, clock: str, time_a: Array, a: Array, time_b: Array, b: Array, max_offset_s: float | None = None, shared: bool = True
) -> ClockReport:
    """Estimate offset and drift of clock ``b`` against clock ``a``.

    Cross-correlation gives the offset of the whole and of windows; a line through the windows starts the drift;
    Gauss-Newton least squares on ``b(t + offset + drift * (t - origin)) = gain * a(t) + level`` refines both.

    Parameters
    ----------
    time_a, a, time_b, b : ndarray, shape (n,), (m,)
        Times in s and values that record the same content up to gain and level.
    max_offset_s : float, optional
        Largest offset looked for (default: half the shorter recording).
    """
    good_a, good_b = np.isfinite(time_a) & np.isfinite(a), np.isfinite(time_b) & np.isfinite(b)
    good_a &= (
        np.concatenate(([True], time_a[1:] > np.maximum.accumulate(np.where(good_a, time_a, -np.inf))[:-1])) if len(time_a) else good_a
    )
    time_a, a, time_b, b = time_a[good_a], a[good_a], time_b[good_b], b[good_b]
    none = ClockReport(reference, clock, None, None, None, None, None, 0.0, shared)
    if min(len(a), len(b)) < MIN_SAMPLES:
        return replace(none, why_not=f"fewer than {MIN_SAMPLES} samples")
    if np.ptp(a) == 0 or np.ptp(b) == 0:
        return replace(none, why_not="a channel is flat")
    step = max(float(np.median(np.diff(time_a))), float(np.median(np.diff(time_b))))
    # epoch times differ by the start of the recorder; the offset is looked for around that difference
    nearby = 0.0 if min(time_a[-1], time_b[-1]) > max(time_a[0], time_b[0]) else float(time_b[0] - time_a[0])
    span = max(time_a[-1], time_b[-1] - nearby) - min(time_a[0], time_b[0] - nearby)
    step = max(step, span / MAX_GRID)
    limit = max_offset_s if max_offset_s is not None else 0.5 * min(np.ptp(time_a), np.ptp(time_b))
    lag, _ = _lag(time_a, a, time_b - nearby, b, step, limit)
    origin = float(np.median(time_a))
    drift = _drift_start(time_a, a, time_b - nearby, b, step, lag)
    found = _refine(time_a, a, time_b, b, lag + nearby, drift, origin, step)
    if found is None:
        return replace(none, why_not="the recordings hardly overlap")
    offset, rate, offset_se, rate_se, correlation = found
    if abs(correlation) < MIN_CORRELATION:
        return replace(none, why_not=f"the contents do not agree (correlation {correlation:.2f})")
    # the fit maps reference to clock; the report maps back, which to first order needs the same numbers
    inverse = rate / (1 + rate)
    return ClockReport(reference, clock, offset, offset_se, inverse * 1e6, rate_se * 1e6, correlation, origin + offset, shared)


def drift_tells(report: ClockReport, time_a: Array, a: Array, time_b: Array, b: Array) -> bool:
    """Return whether a drift explains most of what an offset alone leaves between an input and its output, as friction's loop does not.

    Parameters
    ----------
    report : ClockReport
        What ``compare`` found of the same series.
    time_a, a, time_b, b : ndarray, shape (n,), (m,)
        Times in s and values.
    """
    assert report.offset_s is not None and report.drift_ppm is not None
    origin, drift = report.origin_s - report.offset_s, 1e-6 * report.drift_ppm
    some = slice(None, None, max(1, len(a) // COMPARED))
    moved = abs(drift) * float(np.ptp(time_a)) if len(time_a) else 0.0
    offsets = report.offset_s + np.linspace(-moved, moved, OFFSETS)
    alone = min(_misfit(time_a[some], a[some], time_b, b, float(offset), 0.0, origin) for offset in offsets)
    return _misfit(time_a[some], a[some], time_b, b, report.offset_s, drift, origin) < REMAINS * alone


def _misfit(ta: Array, a: Array, tb: Array, b: Array, offset: float, drift: float, origin: float) -> float:
    """Return what a line from one series leaves of the other (RMS), infinite where they do not meet."""
    y = on_grid(ta + offset + drift * (ta - origin), tb, b)
    good = np.isfinite(y) & np.isfinite(a)
    if good.sum() < MIN_SAMPLES:
        return float("inf")
    line = np.polyfit(a[good], y[good], 1)
    return float(np.sqrt(np.mean((y[good] - np.polyval(line, a[good])) ** 2)))


def _lag(ta: Array, a: Array, tb: Array, b: Array, step: float, limit: float) -> tuple[float, float]:
    """Return by how much ``b`` comes later than ``a`` (s), from the peak of the cross-correlation."""
    start, stop = min(ta[0], tb[0]), max(ta[-1], tb[-1])
    grid = np.arange(start, stop + step / 2, step)
    x, y = _standard(on_grid(grid, ta, a)), _standard(on_grid(grid, tb, b))
    size = 1 << int(np.ceil(np.log2(2 * len(grid))))
    product = np.fft.irfft(np.fft.rfft(y, size) * np.conj(np.fft.rfft(x, size)), size)
    reach = max(1, min(len(grid) - 1, int(limit / step)))
    lags = np.arange(-reach, reach + 1)
    values = np.abs(product[lags])
    best = int(np.argmax(values))
    shift = 0.0
    if 0 < best < len(values) - 1:
        left, mid, right = values[best - 1 : best + 2]
        curve = left - 2 * mid + right
        shift = 0.5 * (left - right) / curve if curve < 0 else 0.0
    return float((lags[best] + shift) * step), float(values[best])


def _standard(values: Array) -> Array:
    inside = np.isfinite(values)
    level, scale = np.mean(values[inside]), np.std(values[inside])
    return np.where(inside, (values - level) / (scale or 1.0), 0.0)


def _drift_start(ta: Array, a: Array, tb: Array, b: Array, step: float, lag: float) -> float:
    """Return a first drift from the lags of windows, or 0 where windows are too short to tell."""
    edges = np.linspace(max(ta[0], tb[0] - lag), min(ta[-1], tb[-1] - lag), WINDOWS + 1)
    width = edges[1] - edges[0]
    if width < 16 * step:
        return 0.0
    centres, lags, weights = [], [], []
    for low, high in pairwise(edges.tolist()):
        grid = np.arange(low, high, step)
        x = on_grid(grid, ta, a)
        if np.std(x) == 0 or not np.isfinite(x).all():
            continue
        reach = width / 8
        trial = np.arange(-reach, reach + step / 2, max(step, reach / 100))
        scores = []
        for shift in trial:
            y = on_grid(grid + lag + shift, tb, b)
            spread = np.std(y)
            scores.append(abs(np.mean((x - x.mean()) * (y - y.mean()))) / (np.std(x) * spread) if spread > 0 else 0.0)
        best = int(np.nanargmax(scores)) if np.isfinite(scores).any() else 0
        if 0 < best < len(trial) - 1 and scores[best] > MIN_CORRELATION:
            centres.append((low + high) / 2)
            lags.append(trial[best])
            weights.append(scores[best])
    if len(centres) < 3:
        return 0.0
    return float(np.polyfit(centres, lags, 1, w=weights)[0])


def _refine(
    ta: Array, a: Array, tb: Array, b: Array, offset: float, drift: float, origin: float, step: float
) -> tuple[float, float, float, float, float] | None:
    """Return offset, drift, their standard errors and the correlation after Gauss-Newton steps."""
    slope = np.gradient(b, tb)
    best: tuple[float, float, float, float, float] | None = None
    for _ in range(30):
        at = ta + offset + drift * (ta - origin)
        y, dy = on_grid(at, tb, b), on_grid(at, tb, slope)
        inside = np.isfinite(y) & np.isfinite(dy)
        if inside.sum() < MIN_SAMPLES:
            return best
        x, y, dy, u = a[inside], y[inside], dy[inside], ta[inside] - origin
        # y(offset, drift) = gain x + level: solve for the four together
        design = np.column_stack([x, np.ones_like(x), -dy, -dy * u])
        scale = np.sqrt((design**2).mean(axis=0)) + 1e-300
        answer, _, rank, _ = np.linalg.lstsq(design / scale, y, rcond=None)
        answer = answer / scale
        residual = y - design @ answer
        spread = float(residual @ residual) / max(len(x) - 4, 1)
        covariance = spread * np.linalg.pinv((design / scale).T @ (design / scale)) / np.outer(scale, scale)
        plain = np.corrcoef(x, y)[0, 1] if np.std(x) > 0 and np.std(y) > 0 else 0.0
        best = (offset, drift, float(np.sqrt(covariance[2, 2])), float(np.sqrt(covariance[3, 3])), float(plain))
        if rank < 4:
            return best
        move, turn = float(np.clip(answer[2], -20 * step, 20 * step)), float(np.clip(answer[3], -1e-2, 1e-2))
        offset, drift = offset + move, drift + turn
        if abs(move) < 1e-6 * step and abs(turn) < 1e-10:
            break
    return best

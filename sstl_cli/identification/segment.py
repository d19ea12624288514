"""Theta of one run: filter, segment, fit a robust line per direction, and say what could not be identified."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import UsageError
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.core.tables import PARAMETERS
from sstl_cli.identification import filtering, labels, lines
from sstl_cli.identification.covariance import Line, fit_lines
from sstl_cli.identification.options import SegmentOptions

Array = NDArray[np.float64]
Codes = NDArray[np.uint8]
MIN_SAMPLES = 16
MIN_BLOCKS = 6
MIN_INLIERS = 0.5
# a slope known no better than this is not reported
MAX_RELATIVE_SE = 0.5
# residuals beyond this share of the range are misfit, not noise, and must not raise the thresholds
SLOWEST = 0.005
# the sum of values up to here is a finite number whatever their count
LARGEST = 1e150
DIRECTIONS = ("pull", "release")


@dataclass(frozen=True)
class Segmentation:
    """What one run shows of its propagation lines.

    ``theta`` and ``theta_se`` map gamma_p, beta_p (N), gamma_r, beta_r (N) to a value or None;
    ``status`` is ``ok`` or says why a value is None. ``rmse_p_n`` and ``rmse_r_n`` are those of the
    inlier block means. ``phases`` has the shape (n,) of the run, codes into ``PHASE_NAMES``.
    ``noise_sd_n`` and ``noise_in_sd_n`` are the white noise of output and input.
    """

    run_id: str
    theta: dict[str, float | None]
    theta_se: dict[str, float | None]
    inlier_p: float | None
    inlier_r: float | None
    rmse_p_n: float | None
    rmse_r_n: float | None
    loops: int
    status: str
    phases: Codes
    noise_sd_n: float | None = None
    noise_in_sd_n: float | None = None
    cutoff_hz: float | None = None
    prominence_n: float | None = None
    delta_bl_n: float | None = None
    filtered_in_n: Array | None = None
    filtered_out_n: Array | None = None

    @property
    def ok(self) -> bool:
        return self.status == "ok"


@dataclass(frozen=True)
class _Fit:
    """Robust line of one direction and its inlier blocks; ``on_line`` is the share of the output's travel they make."""

    slope: float
    bias: float
    share: float
    points: tuple[Array, Array, Array]
    length: int = 1
    reason: str = ""
    on_line: float = math.nan

    @property
    def spread(self) -> float:
        """Residual standard deviation (N) of the inlier blocks."""
        _, x, y = self.points
        return float(np.std(y - self.slope * x - self.bias)) if len(x) else math.nan


EMPTY = (np.empty(0), np.empty(0), np.empty(0))


def segment_run(run: Run, options: SegmentOptions | None = None) -> Segmentation:
    """Return phases and Theta of one run; what cannot be identified is None with its reason.

    Raises
    ------
    UsageError
        If a cut-off lies above half the sampling rate.
    """
    options = options or SegmentOptions()
    if len(run) < MIN_SAMPLES:
        return _nothing(run, f"too few samples ({len(run)})")
    ends_in, ends_out = _ends(run.tension_in_n), _ends(run.tension_out_n)
    refusal = _refusal(run, ends_in, ends_out)
    if refusal:
        return _nothing(run, refusal)
    return _Session(run, options, ends_in[1] - ends_in[0], ends_out[1] - ends_out[0]).result()


def _ends(values: Array) -> tuple[float, float]:
    """Return the smallest and the largest value of a channel, NaN where one is none."""
    return float(np.min(values)), float(np.max(values))


def _refusal(run: Run, ends_in: tuple[float, float], ends_out: tuple[float, float]) -> str:
    time = run.time_s
    rises = bool(np.all(time[1:] > time[:-1]))
    ends = (*ends_in, *ends_out, float(time[0]), float(time[-1]))
    if not (rises and all(-LARGEST <= v <= LARGEST for v in ends)):
        # rarely so: only now every value is looked at
        for name in ("time_s", "tension_in_n", "tension_out_n"):
            values = getattr(run, name)
            bad = int(np.count_nonzero(~np.isfinite(values)))
            if bad:
                return f"{bad} not-a-number values in {name}"
            if not math.isfinite(float(np.sum(values))):
                return f"{name} is too large"
    if not rises:
        return "time repeats or runs backwards"
    for name, (low, high) in (("tension_in_n", ends_in), ("tension_out_n", ends_out)):
        if low == high:
            return f"{name} is constant"
    return ""


def _nothing(run: Run, status: str, phases: Codes | None = None, loops: int = 0) -> Segmentation:
    null: dict[str, float | None] = dict.fromkeys(PARAMETERS)
    codes = np.zeros(len(run), np.uint8) if phases is None else phases
    return Segmentation(run.run_id, null, dict(null), None, None, None, None, loops, status, codes)


class _Session:
    """Intermediate values of one run."""

    def __init__(self, run: Run, options: SegmentOptions, span_in: float, span_out: float) -> None:
        self.run, self.options = run, options
        self.time = np.ascontiguousarray(run.time_s)
        self.dt = filtering.sampling(self.time)
        x, y = np.ascontiguousarray(run.tension_in_n), np.ascontiguousarray(run.tension_out_n)
        self.sd_in, self.sd_out = filtering.noise_sd(x), filtering.noise_sd(y)
        self.x = filtering.bridged(x, self.sd_in, span_in)
        self.y = filtering.bridged(y, self.sd_out, span_out)
        self.cutoff = options.cutoff_hz or filtering.default_cutoff(self.x, self.dt, self.sd_in)
        if self.cutoff * self.dt >= 0.5:
            raise UsageError(
                f"{self.cutoff:g} Hz is not below half the sampling rate ({0.5 / self.dt:.4g} Hz)",
                where=f"--cutoff-hz, run {run.run_id!r}",
                fix="choose a lower cut-off",
                code="E212",
            )
        self.xf, self.yf = filtering.low_pass(self.x, self.y, self.cutoff, self.dt)
        self.motion = labels.Motion(self.xf, self.cutoff, self.dt)
        self.span_out = float(np.ptp(self.yf))
        self.left_in = filtering.filtered_sd(self.sd_in, self.cutoff, self.dt)
        self.white_in = self.left_in
        self.left_out = filtering.filtered_sd(self.sd_out, self.cutoff, self.dt)
        self.block = lines.block_length(len(run), self.dt)
        # both rounds and every block length draw the same numbers
        self.draws = [stream(options.seed, "ransac", run.run_id, d).random((lines.DRAWN * options.ransac_trials, 2)) for d in (0, 1)]

    def _split(self, known: Array, margin: tuple[float, float], floor: float) -> None:
        o = self.options
        span = self.motion.span
        self.prominence = o.prominence_n or labels.default_prominence(span, self.left_in, floor)
        self.delta = o.delta_bl_n or labels.default_delta(self.span_out, self.left_out, floor)
        tie = labels.default_tie(span, self.left_in, self.prominence)
        self.turns, first = labels.turning_points(self.xf, self.prominence, tie)
        self.moves = first != 0
        rules = labels.Rules(self.delta, self.left_in, self.prominence, self.motion)
        rules.margin = margin
        self.codes, self.use, self.reached = labels.split(self.xf, self.yf, self.turns, first, rules.array(), known)

    def _fit(self, direction: int, length: int) -> _Fit:
        sign = 1 - 2 * direction
        t, x, y, stretch = lines.block_means(self.time, self.x, self.y, self.use, sign, length)
        name = DIRECTIONS[direction]
        if len(t) < MIN_BLOCKS:
            if length > 1:
                return self._fit(direction, max(1, length // 4))
            why = "too few propagation samples" if self.reached[direction] else "no propagation reached"
            return _Fit(math.nan, math.nan, math.nan, EMPTY, 1, f"{name}: {why}")
        if float(np.ptp(x)) < 8.0 * max(self.white_in, 1e-12):
            return _Fit(math.nan, math.nan, math.nan, EMPTY, 1, f"{name}: propagation too short for a line")
        given = self.options.ransac_threshold_n
        span = float(np.ptp(y))
        floor = max(3.0 * math.hypot(self.sd_out, self.sd_in) / math.sqrt(length), 1e-4 * span, 1e-12)
        first = given or max(0.05 * span, 2.0 * floor)
        weight = lines.travel(y, stretch)
        slope, bias, threshold = lines.ransac(x, y, first, floor, given is not None, self.draws[direction], weight)
        if not math.isfinite(slope):
            return _Fit(math.nan, math.nan, math.nan, EMPTY, 1, f"{name}: propagation too short for a line")
        inlier = np.abs(y - slope * x - bias) <= threshold
        on_line = float(np.sum(weight[inlier]) / np.sum(weight)) if weight.any() else float(np.mean(inlier))
        return _Fit(slope, bias, float(np.mean(inlier)), (t[inlier], x[inlier], y[inlier]), length, on_line=on_line)

    def _fits(self) -> list[_Fit]:
        return [self._fit(0, self.block), self._fit(1, self.block)]

    def result(self) -> Segmentation:
        """Segment by thresholds, then once more with the lines so found."""
        self._split(labels.NO_LINES, (0.0, 0.0), labels.FIRST_FLOOR)
        fits = self._fits()
        slow = [f.spread / math.sqrt(1.0 + f.slope**2) for f in fits if math.isfinite(f.slope)]
        if slow:
            # noise slower than the filter shows only as residual; thresholds must exceed it as well
            self.left_in = max(self.left_in, min(min(slow), SLOWEST * self.motion.span))
            self.left_out = max(self.left_out, min(min(slow), SLOWEST * self.span_out))
            known = np.array([v for f in fits for v in (f.slope, f.bias)])
            margin = [4.0 * (self.left_out + abs(f.slope) * self.left_in) if math.isfinite(f.slope) else 0.0 for f in fits]
            self._split(known, (margin[0], margin[1]), labels.FLOOR)
            fits = self._fits()
        loops = (len(self.turns) - 1) // 2 if self.moves else 0
        if not self.moves:
            return _nothing(self.run, "input does not move beyond its noise", self.codes)
        return self._assemble(fits, loops)

    def _assemble(self, fits: list[_Fit], loops: int) -> Segmentation:
        solved = fit_lines([(*f.points, f.length) for f in fits], self.dt, self.sd_in, self.sd_out)
        theta: dict[str, float | None] = dict.fromkeys(PARAMETERS)
        errors: dict[str, float | None] = dict.fromkeys(PARAMETERS)
        shares: list[float | None] = [None, None]
        rmse: list[float | None] = [None, None]
        reasons = []
        for d, (fit, line) in enumerate(zip(fits, solved, strict=True)):
            reason = fit.reason or _doubt(d, fit, line)
            if reason or line is None:
                reasons.append(reason)
                continue
            s = "pr"[d]
            theta[f"gamma_{s}"], theta[f"beta_{s}"] = line.gamma, line.beta
            errors[f"gamma_{s}"], errors[f"beta_{s}"] = line.gamma_se, line.beta_se
            shares[d] = fit.share
            _, x, y = fit.points
            rmse[d] = float(np.sqrt(np.mean((y - line.gamma * x - line.beta) ** 2)))
        return Segmentation(
            self.run.run_id,
            theta,
            errors,
            shares[0],
            shares[1],
            rmse[0],
            rmse[1],
            loops,
            "; ".join(reasons) or "ok",
            self.codes,
            self.sd_out,
            self.sd_in,
            self.cutoff,
            self.prominence,
            self.delta,
            self.xf,
            self.yf,
        )


def _doubt(direction: int, fit: _Fit, line: Line | None) -> str:
    """Return why a line is not reported, or nothing."""
    name = DIRECTIONS[direction]
    if fit.on_line < MIN_INLIERS:
        return f"{name}: no consistent line ({100 * fit.on_line:.0f} % of the output's travel on it)"
    if line is None:
        return f"{name}: noise of the input too large for the range in propagation"
    if line.gamma <= 0.0:
        return f"{name}: slope is not positive"
    if line.gamma_se > MAX_RELATIVE_SE * line.gamma:
        return f"{name}: slope uncertain by {100 * line.gamma_se / line.gamma:.0f} %"
    return ""

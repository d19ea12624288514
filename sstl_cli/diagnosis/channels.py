"""Gaps in the channels recorded beside the two tensions: the tracked reference and the position.

The output tension cannot show these effects. The loop is compared where the input tension follows the
recorded reference; the position only on request, because a simulator need not claim to predict it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from sstl_cli.core.runs import Run
from sstl_cli.core.stretches import stretches
from sstl_cli.diagnosis.constants import (
    LAG_SCALES,
    LOOP_HALVINGS,
    LOOP_SLEWS,
    MIN_SAMPLES,
    NO_LOOP,
    POSITION_STARTS,
    POSITION_STEP,
    POSITION_TRIES,
    SAME_SLOPE,
    SLOWEST_LOOP,
    TRACKS,
    USUAL_SHARE,
)
from sstl_cli.diagnosis.driven import known_input
from sstl_cli.diagnosis.evidence import discounted, strengths_charge
from sstl_cli.diagnosis.features import BESIDE, CandidateRow
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.means import bridged
from sstl_cli.diagnosis.readings import gaps
from sstl_cli.diagnosis.recorder import white_noise
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import Drive, Effect
from sstl_cli.physics.effects import get
from sstl_cli.physics.filters import first_order
from sstl_cli.physics.transmission import activate, mean_tension, predict_position
from sstl_cli.physics.transmission.model import drive_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ChannelGap:
    """What one effect makes of a channel beside the output: RMSE before and after (unit of the channel), gain (nats).

    ``moved`` is how far a change goes (RMS) over what the simulator claims of the effect already, infinite where it claims nothing.
    """

    channel: str
    unit: str
    effect: str
    values: dict[str, float]
    rmse_base: float
    rmse_with: float
    noise: float
    gain: float
    moved: float = float("inf")

    @property
    def fall_pct(self) -> float:
        """By how many percent the error falls."""
        return 100.0 * (1.0 - self.rmse_with / max(self.rmse_base, 1e-300))

    def row(self) -> CandidateRow:
        """Return the gap as a candidate of the verdict."""
        k = len(self.values)
        left = (self.rmse_with / max(self.noise, 1e-12)) ** 2
        share = 1.0 - self.rmse_with / max(self.rmse_base, 1e-300)
        # no claim is exact: what is claimed explains so many nats, and is off by a share of that
        worth = discounted(self.gain, USUAL_SHARE, max(self.gain, 0.0) / max(self.moved**2, np.finfo(float).tiny))
        evidence = worth - strengths_charge(k, 2.0 * max(worth, 0.0))
        return CandidateRow((self.effect,), BESIDE, k, self.gain, evidence, evidence, left, 0.0, 0.0, 0, 1.0, share)


@dataclass(frozen=True)
class _Piece:
    """A stretch of a run without a gap, from its first reading on: what the loop was asked for and what it gave (N), which samples were read."""

    asked: Array
    given: Array
    known: NDArray[np.bool_]
    dt_s: float

    def left(self, tau_s: float, inverse_slew: float) -> Array:
        """Return what a loop of these leaves of the readings (N)."""
        late = first_order(self.asked, self.dt_s, tau_s, inverse_slew, float(self.given[0]))
        return np.asarray((self.given - late)[self.known])


def loop_gaps(records: Sequence[Record], had: Mapping[str, float] | None = None) -> list[ChannelGap]:
    """Return the lag of the tension loop where the input follows a recorded reference; ``had`` is that of the simulator, if it has one."""
    following = [r for r in records if r.raw.tension_ref_n is not None and _tracks(r.raw)]
    pieces = [p for r in following for p in _pieces(r)]
    if not pieces:
        return []
    noise = float(np.median([r.faults_in.noise_n for r in following]))

    def residual(p: Array) -> Array:
        return np.concatenate([piece.left(max(p[0], 0.0), max(p[1], 0.0)) for piece in pieces])

    known = had or {}
    base = residual(np.array([known.get("tau_s", 0.0), known.get("inverse_slew_s_per_n", 0.0)]))
    low, high = np.zeros(2), np.array(SLOWEST_LOOP)
    fits = [least_squares(residual, s, bounds=(low, high), x_scale=LAG_SCALES) for s in _starts(residual, pieces)]
    best = min(fits, key=lambda f: f.cost)
    left = residual(best.x)
    values = {"tau_s": float(best.x[0]), "inverse_slew_s_per_n": float(best.x[1])}
    far = _moved(residual(np.zeros(2)), base, left) if had else float("inf")
    gain = log_gain(base, left, left)
    return [ChannelGap("tension_in", "N", "tension_loop_lag", values, _rms(base), _rms(left), max(noise, 1e-9), gain, far)]


def _pieces(r: Record) -> list[_Piece]:
    """Return the stretches of a run between its gaps, in which nobody knows what was asked for."""
    run, found = r.raw, []
    reference = np.asarray(run.tension_ref_n)
    asked = np.isfinite(reference)
    whole = bridged(reference, asked)
    known = known_input(run, r.faults_in) & asked
    for a, b in stretches(gaps(run) == 0):
        if known[a:b].any():
            part = slice(a + int(np.argmax(known[a:b])), b)
            found.append(_Piece(whole[part], run.tension_in_n[part], known[part], run.dt_s))
    return found


def _starts(residual: Callable[[Array], Array], pieces: Sequence[_Piece]) -> list[Array]:
    """Return the best start with a lag alone, with a slew limit alone, and with both; a limit faster than what is asked for does nothing."""
    fastest = max(float(np.abs(np.diff(p.asked)).max(initial=0.0)) / p.dt_s for p in pieces)
    lags = [NO_LOOP[0], *(SLOWEST_LOOP[0] * 0.5 ** np.arange(1, LOOP_HALVINGS))]
    slews = [NO_LOOP[1], *(np.geomspace(1.0 / fastest, SLOWEST_LOOP[1], LOOP_SLEWS) if fastest * SLOWEST_LOOP[1] > 1.0 else ())]
    tries = {(i, k): np.array([tau, slew]) for i, tau in enumerate(lags) for k, slew in enumerate(slews)}
    left = {at: _rms(residual(p)) for at, p in tries.items()}
    parts = [[at for at in tries if (at[0] > 0, at[1] > 0) == there] for there in ((True, False), (False, True), (True, True))]
    return [tries[min(part, key=lambda at: left[at])] for part in parts if part]


def _tracks(run: Run) -> bool:
    """Whether the input follows its reference, at once or behind some loop: one that is slow beside its movement is not like it."""
    reference = np.asarray(run.tension_ref_n)
    good = np.isfinite(reference)
    if good.sum() < MIN_SAMPLES or np.ptp(reference[good]) < 0.5:
        return False
    whole, given = bridged(reference, good), run.tension_in_n[good]
    lags = [0.0, *(SLOWEST_LOOP[0] * 0.5 ** (0.5 * np.arange(2 * LOOP_HALVINGS)))]
    return any(_alike(first_order(whole, run.dt_s, lag, begin=float(run.tension_in_n[0]))[good], given) for lag in lags)


def _alike(asked: Array, given: Array) -> bool:
    slope = float(np.polyfit(asked, given, 1)[0])
    return bool(np.corrcoef(asked, given)[0, 1] > TRACKS and abs(slope - 1.0) < SAME_SLOPE)


def position_gaps(sim: Simulator, tension: Fit, candidates: Sequence[str]) -> list[ChannelGap]:
    """Return what each effect makes of a position recorded beside the tensions, where a line is claimed to be rigid.

    The base predicts the travel of the load alone, with free origin and stiffness for each run, and what the simulator claims beside it;
    an effect that is among that is a change of its parameters.
    """
    effects = [get(i) for i in candidates if get(i).position is not None]
    records = [r for r in sim.problem.records if r.raw.position_in_mm is not None]
    if not records or not effects:
        return []
    measured = [block_mean(_grid(r), r.factor) for r in records]
    noise = float(np.median([white_noise(x) for x in measured]))
    lines = _lines(sim, tension, records, measured)
    base = _position_residual(sim, lines, {})
    found = [_fit_position(sim, lines, e) for e in effects]
    best = min((left for left, _, _ in found), key=_rms)

    def moved(e: Effect, left: Array) -> float:
        if e.id not in sim.fixed:
            return float("inf")
        others = replace(sim, fixed={k: v for k, v in sim.fixed.items() if k != e.id})
        return _moved(_position_residual(others, lines, {}), base, left)

    return [
        ChannelGap("position_in", "mm", e.id, values, _rms(base), _rms(left), max(noise, 1e-6), log_gain(base, left, best), moved(e, left))
        for left, e, values in found
    ]


def _moved(without: Array, base: Array, left: Array) -> float:
    """Return how far a change goes over what is claimed already, of what is left without the claim, with it, and with the change."""
    claimed = _rms(without - base)
    return _rms(base - left) / claimed if claimed > 0.0 else float("inf")


def log_gain(base: Array, left: Array, best: Array) -> float:
    """Return the gain (nats) of one residual over another, of unknown scale, by as many samples as are independent.

    What the best model leaves says how many: a law is never exact, and what it leaves is no noise. Where that is large just where
    the model differs from the base, as with a clock that jitters on fast movements, few of them count (White 1980).
    """
    moved, scatter = (base - left) ** 2, best**2
    alike = float(np.mean(moved * scatter))
    even = min(float(np.mean(moved) * np.mean(scatter)) / alike, 1.0) if alike > 0.0 else 1.0
    return 0.5 * _independent(best) * even * float(np.log(max(_rms(base), 1e-300) / max(_rms(left), 1e-300)) * 2.0)


def _independent(x: Array) -> float:
    """Return how many independent samples a residual has: up to where its autocorrelation ends (Geyer 1992)."""
    n = len(x)
    spectrum = np.abs(np.fft.rfft(x - x.mean(), 2 * n)) ** 2
    acf = np.fft.irfft(spectrum)[:n] / np.arange(n, 0, -1)
    if acf[0] <= 0.0:
        return float(n)
    rho = acf / acf[0]
    # pairs of lags are positive until nothing but chance is left
    pairs = rho[: n // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(pairs <= 0.0)
    total = float(pairs[: int(ends[0]) if len(ends) else len(pairs)].sum())
    return float(n / max(2.0 * total - 1.0, 1.0))


def _grid(r: Record) -> Array:
    position = np.asarray(r.raw.position_in_mm)
    return block_mean(position, r.thin)[: len(r) * r.factor]


def _affine(x: Array, columns: Sequence[Array]) -> Array:
    """Return what is left of ``x`` after its best combination of a constant and the columns."""
    a = np.stack([np.ones_like(x), *columns], axis=1)
    return np.asarray(x - a @ np.linalg.lstsq(a, x, rcond=None)[0])


@dataclass(frozen=True)
class _Line:
    """One run as the position sees it: its drive, output and mean tension along it (N), and position (mm) of the rigid line.

    ``load`` (N, as predicted and as read) and ``measured`` (mm) are on the analysis grid, ``factor`` times coarser, of which
    ``known`` samples count: in a gap nobody knows where the line is.
    """

    theta: float
    drive: Drive
    out: Array
    mean: Array
    rigid: Array
    factor: int
    load: tuple[Array, Array]
    measured: Array
    known: NDArray[np.bool_]


def _lines(sim: Simulator, tension: Fit, records: Sequence[Record], measured: Sequence[Array]) -> list[_Line]:
    none, own, found = activate({}), activate(sim.fixed), []
    for x, r in zip(measured, records, strict=True):
        theta = float(tension.theta[r.config])
        drive = drive_of(r.system, r.location, r.dt_s, r.u, sim.mechanics)
        alone = Simulator(replace(sim.problem, records=(replace(r, known=None),)), sim.mechanics)
        out = alone.predict_fine(tension.theta, {})[0]
        rigid = predict_position(drive, theta, none, out)
        # effects that stretch what carries the tension do not change it
        mean = mean_tension(drive, theta, own, out)
        found.append(_Line(theta, drive, out, mean, rigid, r.factor, (block_mean(out, r.factor), r.y), x, r.weight > 0.0))
    return found


def _position_residual(sim: Simulator, lines: Sequence[_Line], extra: dict[str, dict[str, float]]) -> Array:
    """Return what the simulator's own position effects and ``extra`` leave (mm), origin and load stiffness free."""
    active = activate({**sim.fixed, **extra})
    parts = []
    for line in lines:
        more = predict_position(line.drive, line.theta, active, line.out, line.mean) - line.rigid
        left = line.measured - block_mean(more, line.factor)
        parts.append(_affine(left[line.known], [x[line.known] for x in line.load]))
    return np.concatenate(parts)


def _fit_position(sim: Simulator, lines: Sequence[_Line], effect: Effect) -> tuple[Array, Effect, dict[str, float]]:
    parameters = [p for p in effect.parameters if p.name not in ("c_t_per_n",)]
    there = sim.fixed.get(effect.id, {})

    def residual(p: Array) -> Array:
        values = {q.name: float(np.clip(v, q.low, q.high)) for q, v in zip(parameters, p, strict=True)}
        return _position_residual(sim, lines, {effect.id: {**there, **values}})

    low, high = np.array([p.low for p in parameters]), np.array([p.high for p in parameters])
    had = [np.clip([there[p.name] for p in parameters], low, high)] if there else []
    best = None
    for start in [*had, *(low + share * (high - low) for share in POSITION_STARTS)]:
        done = least_squares(
            residual, start, bounds=(low, high), x_scale=high - low, diff_step=np.full(len(start), POSITION_STEP), max_nfev=POSITION_TRIES
        )
        best = done if best is None or done.cost < best.cost else best
    assert best is not None
    values = {p.name: float(v) for p, v in zip(parameters, best.x, strict=True)}
    return residual(best.x), effect, values


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x))))

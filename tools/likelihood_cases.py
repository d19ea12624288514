"""Recordings of four simulators with given noise, and what the likelihood says of each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sstl_cli.blind import bench as benches
from sstl_cli.blind.bench import PlannedRun
from sstl_cli.blind.record import Effects, Source, Truth
from sstl_cli.blind.simulators import NAMES
from sstl_cli.core.rng import stream
from sstl_cli.diagnosis import hearing
from sstl_cli.diagnosis import noise as noise_of
from sstl_cli.diagnosis.fit import Fit, first_theta, fit, normal_equations, partial, settle
from sstl_cli.diagnosis.found import NOTHING
from sstl_cli.diagnosis.hypotheses import Hypothesis, full
from sstl_cli.diagnosis.latent import Slow, Told, latent
from sstl_cli.diagnosis.recorder import white_beside, white_noise
from sstl_cli.diagnosis.records import Problem, Record, prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.smoother import STATES
from sstl_cli.diagnosis.where import phases
from sstl_cli.diagnosis.whitening import Noise, Phases, white
from sstl_cli.physics.effects import get
from sstl_cli.physics.rig import NoiseSpec
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import drive_of

Array = NDArray[np.float64]
# white and coloured noise (N) and correlation time (s) of both sensors
SETTINGS = (
    (0.005, 0.0, 0.2),
    (0.02, 0.0, 0.2),
    (0.04, 0.0, 0.2),
    (0.01, 0.01, 0.05),
    (0.02, 0.02, 0.3),
    (0.03, 0.03, 1.0),
    (0.01, 0.03, 0.3),
)
FAST = "fast model"
SIMULATORS = (FAST, *NAMES)
RATES_HZ = (100.0, 200.0, 500.0, 125.0, 250.0)
# samples at the analysis rate (50 Hz) of a case
ENOUGH = 8000
FIRST_S = 0.5
# twice the log-likelihood ratio that a true effect is given
AIM = 80.0


@dataclass
class FastSource(Source):
    """A bench whose mechanics are the fast model itself."""

    def _march(self, run: PlannedRun, command_n: Array, mechanical: Effects, friction: Array | None) -> Truth:
        mechanics = self.bench.known.mechanics()
        drive = drive_of(run.system, self.bench.locations[run.config], float(run.time_s[1]), command_n, mechanics)
        active = activate({k: dict(v) for k, v in mechanical.items()})
        return command_n, predict(drive, self.bench.theta[run.config], active), np.zeros(len(command_n))


def source(simulator: str, rate_hz: float, setting: Sequence[float], seed: int, enough: int = ENOUGH) -> Source:
    """Return a drawn bench at a rate with a noise, as many of its runs as are enough."""
    hardware = "rig" if simulator == FAST else simulator
    attempt = 0
    while True:
        bench = benches.draw(stream(seed, "likelihood", simulator, attempt), False, hardware=hardware)
        if bench.rate_hz == rate_hz:
            break
        attempt += 1
    white, coloured, correlation = setting
    # systems take turns: as many runs as are enough hold both
    seconds = np.cumsum([len(r.time_s) / rate_hz for r in bench.runs])
    count = int(np.searchsorted(seconds * 50.0, enough)) + 1
    bench = replace(bench, runs=bench.runs[: max(count, 2)], noise=NoiseSpec(white, coloured, correlation, 0.02))
    return FastSource(bench, seed) if simulator == FAST else Source(bench, seed)


@dataclass(frozen=True)
class Null:
    """A recording with its base, fitted and whitened by the noise that it shows."""

    problem: Problem
    sim: Simulator
    base: Fit
    noise: Noise


def heard(made: Source, effects: Effects, h: Hypothesis = NOTHING, values: Array | None = None) -> Null:
    """Return the recording of a bench with a model fitted to it: the base, or one that starts at given values."""
    problem = prepare(made.record(made.bench.runs, effects))
    sim = Simulator(problem, made.bench.known.mechanics())
    plain = white(1.0, sim.weight, [s.start for s in sim.slices()])
    nominal = np.array([made.bench.theta[int(c[1:]) - 1] for c in problem.configs])
    base = fit(sim, plain, h, first_theta(sim, nominal) if not h.free else nominal, np.zeros(0) if values is None else values)
    measured = noise_of.measured(problem.records, sim.phases(base.theta, base.effects).slide)
    sim, base, found, _ = hearing.heard(sim, [base], measured)
    return Null(sim.problem, sim, settle(sim, found, base), found)


def whiteness(null: Null) -> dict[str, Any]:
    """Return sums of squares and counts by phase, over all and over its first half second, and of neighbours' products."""
    sim, w = null.sim, null.base.whiten
    z, keep, code = w.left(null.base.residual), w.scale > 0, phases(sim, null.base.prediction)
    early = np.zeros(len(z), bool)
    for r, s in zip(sim.problem.records, sim.slices(), strict=True):
        begin = np.concatenate(([0], np.flatnonzero(np.diff(code[s])) + 1))
        at = np.arange(len(r))
        early[s] = (at - begin[np.searchsorted(begin, at, side="right") - 1]) * r.dt_s * r.factor < FIRST_S
    groups = [keep & (code == k) for k in range(4)] + [keep & (code == k) & early for k in range(4)]
    both = keep[1:] & keep[:-1]
    return {
        "square": [float(np.sum(z[g] ** 2)) for g in groups],
        "count": [int(g.sum()) for g in groups],
        "neighbours": float(z[1:][both] @ z[:-1][both]) / float(z @ z),
        "holds": _holds(null),
    }


def _holds(null: Null) -> list[list[float]]:
    """Return for PB and RB the mean over holds of at least half a second of residual (N, at full rate) and its square."""
    sim, sums = null.sim, np.zeros((2, 3))
    fine = sim.predict_fine(null.base.theta, {})
    code = phases(sim, null.base.prediction)
    for r, s, p in zip(sim.problem.records, sim.slices(), fine, strict=True):
        full_rate = np.repeat(code[s], r.factor)
        edges = np.flatnonzero(np.diff(np.concatenate(([-1], full_rate, [-1]))))
        for a, b in zip(edges[:-1], edges[1:], strict=True):
            if full_rate[a] in (0, 2) and (b - a) * r.dt_s >= FIRST_S:
                mean = float(np.mean((r.y_fine - p)[a:b]))
                sums[int(full_rate[a]) // 2] += (1.0, mean, mean**2)
    return [[float(x) for x in row] for row in sums]


def chance(null: Null, effect_id: str) -> tuple[int, float] | None:
    """Return the number of strengths of an effect and twice what they gain (nats), linearised about nothing being missing.

    Shapes stay in the middle of their range: with them free the gain has no known law. None where the recording cannot show
    the effect.
    """
    sim, base = null.sim, null.base
    h = full(effect_id, sim.problem.systems)
    values = np.array([_middle(f.parameter) if f.parameter.shape else f.parameter.neutral for f in h.free])
    strengths = [i for i, f in enumerate(h.free) if not f.parameter.shape]
    if not strengths:
        return None
    columns = base.whiten(
        np.concatenate((base.jacobian[:, :1], partial(sim, base.theta, h.free, values, base.prediction, strengths)), axis=1)
    )
    a, b = normal_equations(sim, columns, base.whiten.left(base.residual))
    configs = len(base.theta)
    follow = np.linalg.lstsq(a[:configs, :configs], np.column_stack((b[:configs], a[:configs, configs:])), rcond=1e-10)[0]
    score = b[configs:] - a[configs:, :configs] @ follow[:, 0]
    gram = a[configs:, configs:] - a[configs:, :configs] @ follow[:, 1:]
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-12))
    gram, score = gram / np.outer(scale, scale), score / scale
    level, axes = np.linalg.eigh(gram)
    # a direction that the recording hardly shows, or that another strength takes, is no freedom
    shown = (level > 1e-3) & (np.max(scale) > 1.0 / 100.0)
    k = int(shown.sum())
    return (k, float(np.sum((axes[:, shown].T @ score) ** 2 / level[shown]))) if k else None


def _middle(p: Any) -> float:
    return float(np.sqrt(p.low * p.high)) if p.low > 0.0 else 0.5 * (p.low + p.high)


def refitted(null: Null, effect_id: str) -> float:
    """Return twice the gain (nats) of an effect refitted with everything free, from the middle of its range."""
    h = full(effect_id, null.sim.problem.systems)
    start = np.array([_middle(f.parameter) if f.parameter.shape else f.parameter.neutral + 1e-3 * f.width for f in h.free])
    begun = fit(null.sim, null.base.whiten, h, null.base.theta, start)
    return 2.0 * max(null.base.cost - settle(null.sim, null.noise, begun).cost, 0.0)


def ratio(effect_id: str, values: dict[str, float], draws: int, seed: int) -> list[float]:
    """Return twice the log-likelihood ratio of the true model over the nested one, a value per draw of the noise.

    The strengths are scaled so that the first draw gives about ``AIM``.
    """
    made = source(FAST, 100.0, SETTINGS[1], seed, 3000)
    whole = full(effect_id, sorted({r.system for r in made.bench.runs}))
    true = Hypothesis(whole.ids, tuple(f for f in whole.free if f.parameter.name in values))
    neutral = np.array([f.parameter.neutral for f in true.free])
    off = np.array([values[f.parameter.name] for f in true.free]) - neutral

    def once(k: int, scale: float) -> float:
        at = neutral + scale * off
        strengths = {f.parameter.name: float(v) for f, v in zip(true.free, at, strict=True)}
        null = heard(replace(made, seed=seed + 1000 * (k + 1), _known={}), {effect_id: strengths}, true, at)
        nested = fit(null.sim, null.base.whiten, NOTHING, null.base.theta, np.zeros(0))
        return 2.0 * (settle(null.sim, null.noise, nested).cost - null.base.cost)

    scale = 1.0
    for _ in range(2):
        scale *= float(np.sqrt(AIM / max(once(0, scale), 1.0)))
    return [float(len(true.free)), *(once(k + 1, scale) for k in range(draws))]


def kept(simulator: str, setting: Sequence[float], seed: int) -> list[float]:
    """Return the share of D^2 that the estimated filter keeps of the exact one, for responses to theta and to effects.

    Exact is the covariance of the residual of one run with the true noise, computed densely: white and coloured noise of the
    input through the smoother's own weights, through the play, and the noise of the output. A filter W that is not its inverse
    finds a response d with (d'Wd)^2 / (d'W C W d) instead of d'C^-1 d.
    """
    null = heard(source(simulator, 100.0, setting, seed, 2000), {})
    sim, noise = null.sim, setting
    r, s = null.problem.records[0], sim.slices()[0]
    seen = sim.phases(null.base.theta, {})
    c = _exact(r, seen.at(s), noise)
    rows = np.zeros((len(sim.y), len(r)))
    rows[s] = np.eye(len(r))
    root = null.base.whiten(rows)[s]
    ids = ("const_friction", "viscous", "gain_error", "zero_offset", "channel_delay", "asymmetric_friction")
    columns = [null.base.jacobian[s, 0]]
    for i in ids:
        h = full(i, sim.problem.systems)
        mine = [k for k, f in enumerate(h.free) if not f.parameter.shape and f.parameter.system in (None, r.system)]
        neutral = np.array([_middle(f.parameter) if f.parameter.shape else f.parameter.neutral for f in h.free])
        columns += list(partial(sim, null.base.theta, h.free, neutral, null.base.prediction, mine)[s].T)
    shares = []
    for d in columns:
        if np.abs(d).max() > 0.0:
            w = root.T @ (root @ d)
            shares.append(float((d @ w) ** 2 / (w @ c @ w) / (d @ np.linalg.solve(c, d))))
    return shares


def _exact(r: Record, seen: Phases, noise: Sequence[float]) -> Array:
    """Return the covariance of the residual of a run at the analysis rate, from the true noise."""
    x, n = r.raw.tension_in_n, len(r)
    slow = Slow(r.told_n, r.told_s)
    spread = white_beside(white_noise(x), slow.sd_n, slow.kept(r.raw.dt_s))
    posterior = covariance(latent(x, r.raw.dt_s, spread, told=Told(slow)).chain)
    lag = np.abs(np.subtract.outer(np.arange(len(x)), np.arange(len(x)))) * r.raw.dt_s
    means = np.kron(np.eye(n), np.full((1, r.factor), 1.0 / r.factor))
    # what a reading counts for in a smoothed value: posterior covariance times the inverse of the noise that was assumed
    assumed = spread**2 * np.eye(len(x)) + slow.sd_n**2 * np.exp(-lag / slow.correlation_s)
    weights = np.linalg.solve(assumed, (means @ posterior[: n * r.factor]).T).T
    into = weights @ (noise[0] ** 2 * np.eye(len(x)) + noise[1] ** 2 * np.exp(-lag / noise[2])) @ weights.T
    mix, begin, kept, held = np.zeros((n, n)), np.zeros(n), np.zeros(n), 1.0
    for t in range(n):
        # what was held before the step, of which its mean and its end have the rest
        slide, left = seen.slide[t], seen.left[t]
        mix[t], begin[t] = (1.0 - slide) * kept, (1.0 - slide) * held
        kept, held = (1.0 - left) * kept, (1.0 - left) * held
        mix[t, t] += slide * seen.gain[t]
        kept[t] += left * seen.gain[t]
    wide = means @ np.exp(-lag[: n * r.factor, : n * r.factor] / noise[2]) @ means.T
    out = noise[1] ** 2 * wide + noise[0] ** 2 / r.factor * np.eye(n)
    return mix @ into @ mix.T + np.outer(begin, begin) * (r.start_error_n**2 + noise[1] ** 2) + out


def covariance(chain: Array) -> Array:
    """Return the covariance (n, n) of the values of a chain of the smoother."""
    n = len(chain)
    found, now, ahead = np.zeros((n, n)), np.zeros((STATES, STATES)), np.zeros((n, STATES))
    for k in range(n):
        move, new = chain[k, : STATES * STATES].reshape(STATES, STATES), np.zeros((STATES, STATES))
        new[np.triu_indices(STATES)] = chain[k, STATES * STATES :]
        now = move @ now @ move.T + new + np.triu(new, 1).T
        # covariance of every earlier value with the state now
        ahead[:k] = ahead[:k] @ move.T
        ahead[k] = now[0]
        found[k, : k + 1] = found[: k + 1, k] = ahead[: k + 1, 0]
    return found


def shown(effect_id: str) -> bool:
    """Whether an effect is compared on tensions."""
    return get(effect_id).channel == "out"

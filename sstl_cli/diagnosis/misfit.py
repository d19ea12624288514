"""What an accepted model leaves of its own record: known from then on, and no change of the rig.

No model of a real rig is complete. What it left when it was accepted has two parts: a mean that comes again wherever the rig
is in the same state, and a scatter about it (model discrepancy, Kennedy and O'Hagan 2001). The state of a line with
rate-independent friction is its input, the direction, and how far it has come since it turned (the first level of its
memory); where motion drives the line, the place along the stroke takes that part. The mean is a map over these, a sum of
hat functions whose weights are drawn to zero as far as parts of the record that were left out ask for it; the scatter is
what the map leaves of those parts beyond the noise of the sensors. A later record is judged against map and scatter.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from sstl_cli.diagnosis.constants import (
    BEYOND_WIDEST,
    CLEAR,
    INPUT_KNOTS,
    KNOTS_FROM,
    KNOTS_TO,
    LEAST_MAPPED,
    MAP_FOLDS,
    OTHER_KNOTS,
    QUIETEST,
    RIDGES,
    SCATTER_FLAT,
    SCATTER_NEAR,
    SCATTER_STEPS,
    SCATTER_TRIES,
    SPREAD,
    WIDEST,
)
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.noise import variance
from sstl_cli.diagnosis.records import Problem, Record
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Noise, Phases, Whitener, constants, whitener
from sstl_cli.physics.scenario import MisfitSection

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def turning(u: Array) -> tuple[Array, Array]:
    """Return the direction of a signal (1 or -1) and its distance from where it last turned, both of shape (n,)."""
    clear = CLEAR * float(np.ptp(u))
    way, last = np.ones(len(u)), np.zeros(len(u))
    high = low = float(u[0])
    direction, turn = 0, float(u[0])
    for i, x in enumerate(u):
        high, low = max(high, x), min(low, x)
        if direction >= 0 and high - x > clear:
            direction, turn, low = -1, high, x
        elif direction <= 0 and x - low > clear:
            direction, turn, high = 1, low, x
        way[i], last[i] = direction, abs(x - turn)
    # before the first reversal the direction is the one that the signal then takes
    first = np.flatnonzero(way != 0.0)
    way[way == 0.0] = way[first[0]] if len(first) else 1.0
    return way, last


def state(r: Record) -> tuple[Array, Array, Array]:
    """Return input, second coordinate and direction of a record at its analysis rate, each of shape (n,)."""
    u = block_mean(r.u, r.factor)
    if r.slip is None or r.raw.position_in_mm is None:
        way, since = turning(u)
        return u, since, way
    place = block_mean(block_mean(r.raw.position_in_mm, r.thin)[: len(r.u)], r.factor)
    return u, place, np.where(block_mean(r.slip, r.factor) < 0.0, -1.0, 1.0)


def learned(problem: Problem, residual: Array, phases: Phases, noise: Noise) -> tuple[tuple[MisfitSection, ...], Array]:
    """Return what a fitted model leaves, one section a system and configuration, and what these leave of parts left out.

    Parameters
    ----------
    residual : ndarray, shape (samples,)
        What the model leaves of the record (N), records laid end to end.
    """
    ends = np.cumsum([len(r) for r in problem.records])
    expected = variance(problem.records, phases, noise)
    found, remains = [], residual.copy()
    for system, config in sorted({(r.system, r.config) for r in problem.records}):
        part = [(r, slice(e - len(r), e)) for r, e in zip(problem.records, ends, strict=True) if (r.system, r.config) == (system, config)]
        section, left = _section(
            [r for r, _ in part], [residual[s] for _, s in part], [expected[s] for _, s in part], problem.configs[config]
        )
        remains[np.concatenate([np.arange(s.start, s.stop) for _, s in part])] = left
        if section is not None:
            own = Phases(*(np.concatenate([x[s] for _, s in part]) for x in (phases.slide, phases.gain, phases.doubt_n)))
            found.append(_scattered(section, [r for r, _ in part], left, own, noise))
    return tuple(found), remains


def _scattered(section: MisfitSection, records: Sequence[Record], left: Array, phases: Phases, noise: Noise) -> MisfitSection:
    """Return a section with the most likely size and correlation time of the scatter, beside the noise of the sensors."""
    where = [_place(section, r, 1.0) for r in records]

    def at(p: Array) -> MisfitSection:
        size = float(np.exp(p[0]))
        return section.model_copy(update={"sd_n": tuple(size * v for v in section.sd_n), "correlation_s": float(np.exp(p[1]))})

    def cost(p: Array) -> float:
        s = at(p)
        known = [replace(r, misfit_n=w @ np.array(s.sd_n), misfit_s=s.correlation_s) for r, w in zip(records, where, strict=True)]
        whiten = whitener(constants(known, noise), phases)
        z = whiten(left)
        # a scatter slower than the record cannot be told from the map
        return 0.5 * (float(z @ z) + whiten.log_det) + float(np.sum((np.maximum(np.abs(p - start) - WIDEST, 0.0)) ** 2)) * BEYOND_WIDEST

    if max(section.sd_n) <= 0.0:
        return section
    start = np.array([0.0, np.log(section.correlation_s)])
    simplex = start + np.array([[0.0, 0.0], [SCATTER_STEPS[0], 0.0], [0.0, SCATTER_STEPS[1]]])
    found = minimize(
        cost,
        start,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "maxfev": SCATTER_TRIES, "xatol": SCATTER_NEAR, "fatol": SCATTER_FLAT},
    )
    return at(found.x)


def _section(
    records: Sequence[Record], residual: Sequence[Array], expected: Sequence[Array], name: str
) -> tuple[MisfitSection | None, Array]:
    """Return the map of what is left and its scatter, and what the map leaves of parts that it was not made from."""
    states = [state(r) for r in records]
    keep = np.concatenate([r.weight > 0 for r in records])
    if keep.sum() < LEAST_MAPPED:
        return None, np.concatenate(residual)
    u, other, way = (np.concatenate([s[i] for s in states]) for i in range(3))
    e = np.concatenate(residual)
    first, second = _knots(u[keep], INPUT_KNOTS), _knots(other[keep], OTHER_KNOTS)
    design = _design(u, other, way, first, second)
    fold = np.concatenate([np.arange(len(r)) * MAP_FOLDS // len(r) for r in records])
    step = records[0].dt_s * records[0].factor
    best = (float(np.sum((e * keep) ** 2)), RIDGES[-1], e)
    for ridge in RIDGES:
        left = e.copy()
        for k in range(MAP_FOLDS):
            others = keep & (fold != k)
            left[fold == k] -= design[fold == k] @ _weights(design[others], e[others], ridge)
        cost = float(np.sum((left * keep) ** 2))
        if cost < best[0]:
            best = (cost, ridge, left)
    _, ridge, left = best
    weights = _weights(design[keep], e[keep], ridge)
    cuts = np.cumsum([len(r) for r in records])[:-1]
    memory = _memory(np.split(left, cuts), records)
    beyond = left**2 - np.concatenate(expected)
    usual = float(np.mean(beyond[keep]))
    # the scatter has its places too: large where the line lets go, small where it slides
    spread = usual + _weights(design[keep], beyond[keep] - usual, SPREAD * memory)
    sd = np.sqrt(np.clip(spread, QUIETEST * usual, None)) if usual > 0.0 else np.zeros(len(spread))
    if ridge == RIDGES[-1] and usual <= 0.0:
        return None, left
    section = MisfitSection(
        system=records[0].system,
        config_id=name,
        along="position" if records[0].slip is not None else "turning",
        correlation_s=step * memory,
        input_n=tuple(first.tolist()),
        other=tuple(second.tolist()),
        mean_n=tuple(weights.tolist()),
        sd_n=tuple(sd.tolist()),
    )
    return section, left


def _knots(x: Array, count: int) -> Array:
    low, high = np.quantile(x, (KNOTS_FROM, KNOTS_TO))
    return np.linspace(low, high, count) if high > low else np.array([low])


def _hats(x: Array, knots: Array) -> Array:
    """Return the hat functions of knots at points, shape (n, knots); beyond the ends they stay as they are there."""
    if len(knots) == 1:
        return np.ones((len(x), 1))
    at = np.clip((x - knots[0]) / (knots[1] - knots[0]), 0.0, len(knots) - 1.0)
    return np.asarray(np.maximum(1.0 - np.abs(at[:, None] - np.arange(len(knots))), 0.0))


def _design(u: Array, other: Array, way: Array, first: Array, second: Array) -> Array:
    both = (_hats(u, first)[:, :, None] * _hats(other, second)[:, None, :]).reshape(len(u), -1)
    return np.concatenate((both * (way > 0)[:, None], both * (way < 0)[:, None]), axis=1)


def _weights(design: Array, e: Array, ridge: float) -> Array:
    gram = design.T @ design + ridge * np.eye(design.shape[1])
    return np.asarray(np.linalg.solve(gram, design.T @ e))


def _memory(residual: Iterable[Array], records: Sequence[Record]) -> float:
    """Return over how many samples a residual is like itself: the first lag with a correlation below 1/e."""
    pieces = [x * (r.weight > 0) for x, r in zip(residual, records, strict=True)]
    power = sum(float(x @ x) for x in pieces)
    if power <= 0.0:
        return 1.0
    longest = max(len(x) for x in pieces) // MAP_FOLDS
    lag = 1
    while lag < longest and sum(float(x[lag:] @ x[:-lag]) for x in pieces if len(x) > lag) > power * float(np.exp(-1.0)):
        lag += 1
    return float(lag)


def applied(problem: Problem, sections: Sequence[MisfitSection], unit_n: float) -> Problem:
    """Return a problem whose records know what the simulator leaves: the mean joins the prediction, the scatter the noise."""
    if not sections:
        return problem
    by_key: dict[tuple[str, str], MisfitSection] = {(s.system, s.config_id): s for s in sections}
    return replace(problem, records=tuple(_known(r, problem.configs[r.config], by_key, unit_n) for r in problem.records))


def _known(r: Record, name: str, by_key: Mapping[tuple[str, str], MisfitSection], unit_n: float) -> Record:
    own = by_key.get((r.system, name))
    along = "position" if r.slip is not None else "turning"
    if own is None or own.along != along:
        # a bend that the model has not seen: how much it leaves is known, not where
        others = [s for s in by_key.values() if s.system == r.system]
        if not others:
            return r
        total = float(np.sqrt(np.mean([np.mean(np.square(s.mean_n)) + np.mean(np.square(s.sd_n)) for s in others]))) / unit_n
        return replace(r, misfit_n=np.full(len(r), total), misfit_s=float(np.median([s.correlation_s for s in others])))
    place = _place(own, r, unit_n)
    mean, sd = place @ np.array(own.mean_n) / unit_n, place @ np.array(own.sd_n) / unit_n
    return replace(r, known=np.repeat(mean, r.factor), misfit_n=sd, misfit_s=own.correlation_s)


def _place(section: MisfitSection, r: Record, unit_n: float) -> Array:
    """Return the weights of a section's knots at every sample of a record in units of ``unit_n``, shape (n, 2 knots knots)."""
    second = np.array(section.other) / (unit_n if section.along == "turning" else 1.0)
    return _design(*state(r), np.array(section.input_n) / unit_n, second)


def beyond(sim: Simulator, accepted: Fit, sections: Sequence[MisfitSection], noise: Noise) -> tuple[Simulator, Whitener]:
    """Return the simulator that knows what it leaves, and the whitener of its scatter."""
    bare = replace(sim.problem, records=tuple(replace(r, known=None) for r in sim.problem.records))
    knowing = Simulator(applied(bare, sections, 1.0), sim.mechanics, sim.fixed)
    return knowing, whitener(knowing.constants({}, noise), knowing.phases(accepted.theta, accepted.effects, noise))


def known(problem: Problem) -> Array:
    """Return what the simulator is known to leave (N, shape (samples,))."""
    return np.concatenate([np.zeros(len(r)) if r.known is None else block_mean(r.known, r.factor) for r in problem.records])


def rms_n(problem: Problem) -> float:
    """Return the RMS (N) of what the simulator is known to leave of these records, 0 where nothing is known."""
    weight = np.concatenate([r.weight for r in problem.records])
    scatter = np.concatenate([np.zeros(len(r)) if r.misfit_n is None else r.misfit_n for r in problem.records])
    return float(np.sqrt(np.sum(weight * (known(problem) ** 2 + scatter**2)) / max(float(weight.sum()), 1.0)))


def rescaled(section: MisfitSection, unit_n: float) -> MisfitSection:
    """Return a section that was learned in units of ``unit_n`` (N) in newtons."""

    def times(values: Sequence[float]) -> tuple[float, ...]:
        return tuple(unit_n * v for v in values)

    return section.model_copy(
        update={
            "input_n": times(section.input_n),
            "mean_n": times(section.mean_n),
            "sd_n": times(section.sd_n),
            "other": times(section.other) if section.along == "turning" else section.other,
        }
    )

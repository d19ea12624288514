"""What an accepted model leaves of its own record, learned: a map over the rig's state, and the scatter about it.

The map is a Gaussian process of which nearby places are alike. Its size, and size, correlation time, correlation path and tail
of the scatter, are the most likely ones (evidence, MacKay 1992); how far the map may be off is known too: little where the
record has been often, as much as it is large where it has never been.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from sstl_cli.diagnosis import state, tails
from sstl_cli.diagnosis.constants import (
    BEYOND_WIDEST,
    DECIDES_NATS,
    INPUT_KNOTS,
    LEAST_MAPPED,
    MAP_SIZES,
    OTHER_KNOTS,
    PARTS,
    QUIETEST,
    SCATTER_FLAT,
    SCATTER_NEAR,
    SCATTER_STEP,
    SPREAD,
    TAIL,
    TAIL_ROUNDS,
    TRIES,
    UNSEEN_SHARE,
    WIDEST,
)
from sstl_cli.diagnosis.laid import constants
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.noise import variance
from sstl_cli.diagnosis.records import Problem, Record
from sstl_cli.diagnosis.whitening import Noise, Phases, Whitener, whitener
from sstl_cli.physics.scenario import MisfitSection

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Map:
    """A map of one system and bend: the state's places (samples, knots), where the record says something, its residual (N),
    what a perfect model would leave of it (N^2), and factors of the prior covariance of a map of unit size (knots, knots).
    """

    records: Sequence[Record]
    design: Array
    keep: NDArray[np.bool_]
    residual: Array
    expected: Array
    phases: Phases
    noise: Noise
    prior: Array

    def whitener(self, sd: Array, slow_s: float, far: float) -> Whitener:
        """Return the whitener of sensors and scatter of standard deviation ``sd`` (N, shape (samples,)), see ``state.lasting``."""
        ends = np.cumsum([len(r) for r in self.records])[:-1]
        known = [
            replace(r, misfit_n=s, misfit_s=state.lasting(r, slow_s, far)) for r, s in zip(self.records, np.split(sd, ends), strict=True)
        ]
        return whitener(constants(known, self.noise), self.phases)


@dataclass(frozen=True)
class _Posterior:
    """How likely a size of the map is (nats, less is better), and what it is then: mean and factor of its covariance."""

    cost: float
    size_n: float
    mean: Array
    factor: Array


def learned(problem: Problem, residual: Array, phases: Phases, noise: Noise) -> tuple[MisfitSection, ...]:
    """Return what a fitted model leaves, one section a system and configuration; none where that is noise.

    Parameters
    ----------
    residual : ndarray, shape (samples,)
        What the model leaves of the record (N), records laid end to end.
    """
    ends = np.cumsum([len(r) for r in problem.records])
    expected = variance(problem.records, phases, noise)
    found = []
    for system, config in sorted({(r.system, r.config) for r in problem.records}):
        part = [(r, slice(e - len(r), e)) for r, e in zip(problem.records, ends, strict=True) if (r.system, r.config) == (system, config)]
        records, where = [r for r, _ in part], np.concatenate([np.arange(s.start, s.stop) for _, s in part])
        if sum(np.count_nonzero(r.weight) for r in records) < LEAST_MAPPED:
            continue
        own = phases.at(where)
        section = _section(records, residual[where], expected[where], own, noise, problem.configs[config])
        if section is not None:
            found.append(section)
    return tuple(found)


def _section(records: Sequence[Record], residual: Array, expected: Array, phases: Phases, noise: Noise, name: str) -> MisfitSection | None:
    """Return the map of what is left, its doubt and its scatter; None where noise alone is as likely."""
    u, other, way = (np.concatenate(x) for x in zip(*(state.state(r) for r in records), strict=True))
    keep = np.concatenate([r.weight > 0 for r in records])
    first, second = state.knots(u[keep], INPUT_KNOTS), state.knots(other[keep], OTHER_KNOTS)
    design = state.design(u, other, way, first, second)
    m = _Map(records, design, keep, residual, expected, phases, noise, np.asarray(np.linalg.cholesky(state.alike(len(first), len(second)))))
    step = records[0].dt_s * records[0].factor
    even = np.ones(design.shape[1])
    span = _knots_apart(second if records[0].slip is not None else first)
    rough = residual - _rough(m)
    begin = (_usual(m, rough**2), step * _memory(m, rough), span, TAIL)
    scatter, found = _scatter(m, even, begin)
    # the scatter has its places too: large where the line lets go, small where it slides
    left = residual - design @ found.mean
    beyond = left**2 + np.sum((design @ found.factor) ** 2, axis=1) - expected
    _, slow, far, _ = scatter
    memory = float(np.median(np.concatenate([state.lasting(r, slow, far) for r in records]))) / step
    places = _places(m, beyond, memory)
    scatter, found = _scatter(m, places, scatter)
    usual, slow, far, tail = scatter
    nothing = m.whitener(np.zeros(len(residual)), slow, far)
    z = nothing(residual)
    if 0.5 * (float(z @ z) + nothing.log_det) - found.cost < DECIDES_NATS:
        return None
    return MisfitSection(
        system=records[0].system,
        config_id=name,
        along="position" if records[0].slip is not None else "turning",
        correlation_s=float(slow),
        correlation_path=float(far),
        tail=float(tail),
        input_n=tuple(first.tolist()),
        other=tuple(second.tolist()),
        mean_n=tuple(found.mean.tolist()),
        sd_n=tuple((usual * places).tolist()),
        size_n=found.size_n,
        doubt_n=tuple(tuple(c) for c in _short(found.factor).T.tolist()),
        rate_n_s=(_fastest(records, 1.0), _fastest(records, -1.0)),
    )


def _scatter(m: _Map, places: Array, begin: Sequence[float] | Array) -> tuple[Array, _Posterior]:
    """Return the most likely size (N), correlation time (s), correlation path and tail of the scatter, and the map beside it.

    Parameters
    ----------
    places : ndarray, shape (knots,)
        Scatter at the knots over the usual one.
    begin : sequence of float
        Where the search begins.
    """
    shape = m.design @ places
    # directions that the record does not show cost time and say nothing
    columns = m.design @ m.prior
    size, way = np.linalg.eigh(columns[m.keep].T @ columns[m.keep])
    seen = columns @ way[:, size > UNSEEN_SHARE * float(size.sum())]
    start = np.log(begin)

    def cost(p: Array) -> float:
        usual, slow, far, tail = np.exp(p)
        # a scatter slower than the record cannot be told from the map
        return _posterior(m, m.whitener(usual * shape, slow, far), seen, tail).cost + BEYOND_WIDEST * float(
            np.sum((np.maximum(np.abs(p - start) - WIDEST, 0.0)) ** 2)
        )

    simplex = start + np.vstack((np.zeros(len(start)), SCATTER_STEP * np.eye(len(start))))
    options = {"initial_simplex": simplex, "maxfev": TRIES, "xatol": SCATTER_NEAR, "fatol": SCATTER_FLAT}
    found = np.exp(minimize(cost, start, method="Nelder-Mead", options=options).x)
    usual, slow, far, tail = found
    best = _posterior(m, m.whitener(usual * shape, slow, far), columns, tail)
    return found, replace(best, mean=m.prior @ best.mean, factor=m.prior @ best.factor)


def _knots_apart(knots: Array) -> float:
    return float(knots[1] - knots[0]) if len(knots) > 1 else 1.0


def _fastest(records: Sequence[Record], way: float) -> float:
    """Return the fastest (N/s) that the input has gone one way."""
    return float(max(block_mean(np.maximum(way * r.rate, 0.0), r.factor).max() for r in records))


def _posterior(m: _Map, whiten: Whitener, columns: Array, tail: float) -> _Posterior:
    """Return the most likely size of a map, and how likely it is (nats) where the scatter has a heavy ``tail`` (see tails)."""
    z = whiten(np.column_stack((m.residual, columns)))
    left, d = z[:, 0], z[:, 1:]
    trust = np.ones(len(left))
    power = MAP_SIZES[:, None] ** 2 * float(np.mean(m.residual[m.keep] ** 2))
    for _ in range(TAIL_ROUNDS):
        by = d * trust[:, None]
        information, way = np.linalg.eigh(by.T @ d)
        score = way.T @ (by.T @ left)
        grown = 1.0 + power * np.maximum(information, 0.0)
        best = int(np.argmin(np.sum(np.log(grown) - power * score**2 / grown, axis=1)))
        shrunk = power[best] / grown[best]
        rest = left - d @ (way @ (shrunk * score))
        trust = tails.trust(rest, tail)
    drawn = float(np.sum(shrunk * score**2 / grown[best]))
    cost = float(tails.nats(rest[m.keep], tail).sum()) + 0.5 * (drawn + float(np.sum(np.log(grown[best]))) + whiten.log_det)
    return _Posterior(cost, float(np.sqrt(power[best, 0])), way @ (shrunk * score), way * np.sqrt(shrunk))


def _rough(m: _Map) -> Array:
    """Return a first map of what is left at every sample (N), as if one reading were as good as another."""
    columns = m.design @ m.prior
    known = columns[m.keep]
    gram = known.T @ known + np.eye(known.shape[1])
    return np.asarray(columns @ np.linalg.solve(gram, known.T @ m.residual[m.keep]))


def _usual(m: _Map, squares: Array) -> float:
    """Return the scatter (N) where a search for it begins: what there is beyond noise."""
    beyond = float(np.mean(squares[m.keep]) - np.mean(m.expected[m.keep]))
    return float(np.sqrt(max(beyond, UNSEEN_SHARE * float(np.mean(m.expected[m.keep])))))


def _places(m: _Map, beyond: Array, memory: float) -> Array:
    """Return the scatter at every knot over the usual one, shape (knots,), from squares beyond noise (N^2, shape (samples,))."""
    usual = float(np.mean(beyond[m.keep]))
    if usual <= 0.0:
        return np.ones(m.design.shape[1])
    known = m.design[m.keep]
    ridge = SPREAD * max(memory, 1.0) * np.eye(known.shape[1])
    spread = 1.0 + np.linalg.solve(known.T @ known + ridge, known.T @ (beyond[m.keep] / usual - 1.0))
    return np.asarray(np.sqrt(np.clip(spread, QUIETEST, None)))


def _short(factor: Array) -> Array:
    """Return the fewest columns of a factor of a covariance that say all but a hundredth of it."""
    u, s, _ = np.linalg.svd(factor, full_matrices=False)
    power = np.cumsum(s**2)
    count = int(np.searchsorted(power, (1.0 - UNSEEN_SHARE) * power[-1])) + 1
    return np.asarray(u[:, :count] * s[:count])


def _memory(m: _Map, residual: Array) -> float:
    """Return over how many samples a residual is like itself: the first lag with a correlation below 1/e."""
    ends = np.cumsum([len(r) for r in m.records])[:-1]
    pieces = np.split(residual * m.keep, ends)
    power = sum(float(x @ x) for x in pieces)
    if power <= 0.0:
        return 1.0
    longest = max(len(x) for x in pieces) // PARTS
    lag = 1
    while lag < longest and sum(float(x[lag:] @ x[:-lag]) for x in pieces if len(x) > lag) > power * float(np.exp(-1.0)):
        lag += 1
    return float(lag)

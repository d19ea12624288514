"""Which effects explain the gap: every candidate refitted in the simulator, alone and combined."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.fit import Fit, fit, jacobian, normal_equations
from sstl_cli.diagnosis.simulator import Free, Simulator, as_effects, free_parameters
from sstl_cli.diagnosis.whitening import Whitener, fit_whitener, identity

Array = NDArray[np.float64]
SHAPE_GRID = (0.15, 0.5, 0.85)
COARSE_ITERATIONS = 6
RICH_FITS = 4
PAIR_LEADERS = 3
PAIR_PARTNERS = 6


@dataclass
class Search:
    """The fitted models of a diagnosis: the base, every single candidate, and combinations."""

    sim: Simulator
    whiten: Whitener
    base: Fit
    fits: dict[tuple[str, ...], Fit] = field(default_factory=dict)

    def leaders(self, size: int) -> list[Fit]:
        """Return the fits with ``size`` effects, best first by penalised cost."""
        found = [f for ids, f in self.fits.items() if len(ids) == size]
        return sorted(found, key=lambda f: (penalised(f, self.sim.problem.samples), f.ids))


def penalised(f: Fit, samples: int) -> float:
    """Return the whitened cost (nats) with half a log-sample charge for each free parameter."""
    return f.cost + 0.5 * len(f.free) * float(np.log(max(samples, 2)))


def starts(free: Sequence[Free]) -> list[Array]:
    """Return starting values: strengths a little off neutral, shapes on a coarse grid.

    Shapes that span decades are spread logarithmically.
    """
    axes: list[list[float]] = []
    for f in free:
        p = f.parameter
        if p.name == "load_mm_per_n":
            axes.append([p.neutral])
        elif p.shape:
            log = p.low > 0 and p.high / p.low > 20
            axes.append(
                [float(p.low * (p.high / p.low) ** g) if log else p.low + g * (p.high - p.low) for g in SHAPE_GRID]
            )
        elif p.low < p.neutral < p.high:
            axes.append([p.neutral])
        else:
            axes.append([p.neutral + 0.08 * (p.high - p.neutral if p.high > p.neutral else p.low - p.neutral)])
    return [np.array(v) for v in itertools.product(*axes)]


def screen(sim: Simulator, whiten: Whitener, around: Fit, ids: Sequence[str]) -> tuple[float, Array]:
    """Return the linearised gain in nats of adding effects to a fit, and the start that gives it."""
    free = _without(free_parameters(ids, sim.problem.systems), around.free)
    best = (-np.inf, np.zeros(len(free)))
    for start in starts(free):
        joined = (*around.free, *free)
        values = np.concatenate((around.values, start))
        prediction = sim.predict(around.theta, as_effects(joined, values))
        j = whiten(jacobian(sim, around.theta, joined, values, prediction))
        r = whiten(sim.y - prediction)
        a, b = normal_equations(sim, j, r)
        step = np.linalg.lstsq(a + 1e-6 * np.diag(np.diag(a) + 1e-9), b, rcond=1e-10)[0]
        step = _inside(step, values, joined, len(around.theta))
        gain = around.cost - (0.5 * float(r @ r) - float(b @ step) + 0.5 * float(step @ a @ step))
        if gain > best[0]:
            best = (gain, start)
    return best


def _without(free: list[Free], known: Sequence[Free]) -> list[Free]:
    """Leave out what the fit around has already: two effects of the line share its load."""
    return [f for f in free if f not in known]


def _inside(step: Array, values: Array, free: Sequence[Free], configs: int) -> Array:
    low = np.array([f.parameter.low for f in free])
    high = np.array([f.parameter.high for f in free])
    step = step.copy()
    step[configs:] = np.clip(values + step[configs:], low, high) - values
    return step


def run(
    sim: Simulator, ids: Sequence[str], theta0: Array, max_effects: int, advance: Callable[[float], None] = lambda _: None
) -> Search:
    """Fit the base, every candidate, and combinations of up to ``max_effects`` effects.

    First unwhitened, then whitened with one filter from the richest model: a filter fitted to the
    base residual could hide the effect, and a whitened fit from a poor start gets stuck.
    """
    slices = sim.slices()
    groups = [r.system for r in sim.problem.records]
    plain = identity(slices, sim.weight)
    rough = fit(sim, plain, (), (), theta0, np.zeros(0))
    spread = float(np.sqrt(np.sum(sim.weight * rough.residual**2) / max(sim.weight.sum(), 1.0)))
    plain = identity(slices, sim.weight, max(spread, 1e-9))
    base = fit(sim, plain, (), (), rough.theta, np.zeros(0), 4)
    coarse: list[Fit] = []
    for effect_id in ids:
        free = free_parameters((effect_id,), sim.problem.systems)
        if free:
            _, start = screen(sim, plain, base, (effect_id,))
            coarse.append(fit(sim, plain, (effect_id,), free, base.theta, start, COARSE_ITERATIONS))
        advance(1)
    coarse.sort(key=lambda f: (f.cost, f.ids))
    whiten = fit_whitener(_richest(sim, plain, base, coarse), sim.weight, slices, groups)
    search = Search(sim, whiten, fit(sim, whiten, (), (), base.theta, np.zeros(0)))
    for c in coarse:
        search.fits[c.ids] = fit(sim, whiten, c.ids, c.free, c.theta, c.values)
        advance(1)
    for size in range(2, max_effects + 1):
        _combine(search, ids, size)
        advance(len(ids) / max(max_effects - 1, 1))
    return search


def _richest(sim: Simulator, plain: Whitener, base: Fit, coarse: Sequence[Fit]) -> Array:
    """Return the residual (N) of the best few candidates fitted together, linearised about the best."""
    if not coarse:
        return base.residual
    best = coarse[0]
    columns = [best.jacobian[:, 1:]] + [c.jacobian[:, 1:] for c in coarse[1:RICH_FITS]]
    j = np.concatenate([best.jacobian[:, :1], *columns], axis=1)
    r = plain(best.residual)
    jw = plain(j)
    a, b = normal_equations(sim, jw, r)
    a += 1e-4 * np.diag(np.diag(a) + 1e-12)
    step = np.linalg.lstsq(a, b, rcond=1e-10)[0]
    configs = len(best.theta)
    return best.residual - j[:, 0] * step[:configs][sim.config] - j[:, 1:] @ step[configs:]


def _combine(search: Search, ids: Sequence[str], size: int) -> None:
    """Extend the best models of ``size - 1`` effects by the partners whose linearised gain is largest."""
    sim, whiten = search.sim, search.whiten
    for leader in search.leaders(size - 1)[: PAIR_LEADERS if size == 2 else 1]:
        partners = []
        for effect_id in ids:
            if effect_id in leader.ids or not free_parameters((effect_id,), sim.problem.systems):
                continue
            key = tuple(sorted((*leader.ids, effect_id)))
            if key in search.fits:
                continue
            gain, start = screen(sim, whiten, leader, (effect_id,))
            partners.append((gain, key, effect_id, start))
        partners.sort(key=lambda p: (-p[0], p[1]))
        for _, key, effect_id, start in partners[:PAIR_PARTNERS]:
            free = (*leader.free, *_without(free_parameters((effect_id,), sim.problem.systems), leader.free))
            values = np.concatenate((leader.values, start))
            search.fits[key] = fit(sim, whiten, (*leader.ids, effect_id), free, leader.theta, values)

"""Which effects explain the gap: every candidate refitted in the simulator, alone and combined."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.fit import Fit, fit, jacobian, normal_equations
from sstl_cli.diagnosis.records import representatives
from sstl_cli.diagnosis.sawtooth import FAMILY
from sstl_cli.diagnosis.simulator import Free, Simulator, as_effects, free_parameters
from sstl_cli.diagnosis.whitening import Whitener, fit_whitener, identity, spread_whitener
from sstl_cli.physics.effect import TRANSITION

Array = NDArray[np.float64]
T = TypeVar("T")
R = TypeVar("R")
SHAPE_GRID = (0.15, 0.5, 0.85)
STRENGTHS = (0.01, 0.08)
COARSE_ITERATIONS = 6
SHORT_ITERATIONS = 2
RICH_FITS = 4
# full refits: at least these many, at most these many, and only with this share of the best gain
LEAST_FITS = 4
REFINED = 10
REFINED_SHARE = 0.3
LEAST_GAIN = 0.005
PAIR_LEADERS = 2
# samples of a stroke that count as one where a motion drives the run
STROKE_SAMPLES = 50.0
PAIR_PARTNERS = 4


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

    Shapes that span decades are spread logarithmically. Strengths of effects of the line are tried weak and strong:
    their response is so far from linear that the step from a strong start says nothing of a weak effect.
    """
    axes: list[list[float]] = []
    offsets = STRENGTHS if any(f.effect.stage == TRANSITION for f in free) else STRENGTHS[-1:]
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
            reach = p.high - p.neutral if p.high > p.neutral else p.low - p.neutral
            axes.append([p.neutral + o * reach for o in offsets])
    return [np.array(v) for v in itertools.product(*axes)]


def screen(
    sim: Simulator, whiten: Whitener, around: Fit, ids: Sequence[str], warm: Array | None = None
) -> tuple[float, Array]:
    """Return the linearised gain in nats of adding effects to a fit, and the start that gives it.

    ``warm`` are values found for the effects alone; their shapes then need no grid.
    """
    everything = free_parameters(ids, sim.problem.systems)
    free = _without(everything, around.free)
    best = (-np.inf, np.zeros(len(free)))
    grid = starts(free)
    if warm is not None:
        known = dict(zip(everything, warm, strict=True))
        grid = [np.array([known[f] if f.parameter.shape else v for f, v in zip(free, g, strict=True)]) for g in grid]
        grid = [np.array(g) for g in dict.fromkeys(tuple(g) for g in grid)]
    for start in grid:
        joined = (*around.free, *free)
        values = np.concatenate((around.values, start))
        prediction = sim.predict(around.theta, as_effects(joined, values))
        j = whiten(jacobian(sim, around.theta, joined, values, prediction))
        r = whiten(sim.y - prediction)
        a, b = normal_equations(sim, j, r)
        step = np.linalg.lstsq(a + 1e-6 * np.diag(np.diag(a) + 1e-9), b, rcond=1e-10)[0]
        step = _inside(np.asarray(step, np.float64), values, joined, len(around.theta))
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
    sim: Simulator,
    ids: Sequence[str],
    theta0: Array,
    max_effects: int,
    advance: Callable[[float], None] = lambda _: None,
    workers: int = 1,
    noise_n: float = 0.0,
    partner_share: float = 0.0,
) -> Search:
    """Fit the base, every candidate, and combinations of up to ``max_effects`` effects.

    First unwhitened and on representative runs, then whitened with one filter from the richest model: a
    filter fitted to the base residual could hide the effect, and a whitened fit from a poor start gets stuck.
    Combinations are tried only while more than noise (``noise_n``, N) is left for a further effect to carry
    ``partner_share`` of the gap.
    """
    small = _reduced(sim)
    chosen = [sim.problem.configs.index(c) for c in small.problem.configs]
    plain = identity(small.slices(), small.weight)
    rough = fit(small, plain, (), (), theta0[chosen], np.zeros(0))
    spread = float(np.sqrt(np.sum(small.weight * rough.residual**2) / max(small.weight.sum(), 1.0)))
    plain = identity(small.slices(), small.weight, max(spread, 1e-9))
    base = fit(small, plain, (), (), rough.theta, np.zeros(0), 4)

    possible = [i for i in ids if free_parameters((i,), small.problem.systems)]

    def promise(effect_id: str) -> tuple[float, str, Array]:
        gain, start = screen(small, plain, base, (effect_id,))
        advance(1)
        return -gain, effect_id, start

    ranked = sorted(_each(promise, possible, workers), key=lambda p: p[:2])

    def alone(place: int) -> Fit:
        gain, effect_id, start = ranked[place]
        # what cannot take half a percent of the error is not worth a fit, unless it is among the best anyway
        tries = COARSE_ITERATIONS if place < LEAST_FITS or -gain > LEAST_GAIN * base.cost else SHORT_ITERATIONS
        return fit(small, plain, (effect_id,), free_parameters((effect_id,), small.problem.systems), base.theta, start, tries)

    coarse = sorted(_each(alone, range(len(ranked)), workers), key=lambda f: (f.cost, f.ids))
    groups = [r.system for r in small.problem.records]
    start_theta = theta0.copy()
    start_theta[:] = float(np.mean(base.theta))
    start_theta[chosen] = base.theta
    rough = fit(sim, identity(sim.slices(), sim.weight, max(spread, 1e-9)), (), (), start_theta, np.zeros(0), 4)
    if any(r.slip is not None for r in sim.problem.records):
        # strokes at constant load differ by their level alone, which a filter of innovations would take away
        sample, whiten = (
            identity(x.slices(), x.weight, spread * STROKE_SAMPLES**0.5) for x in (small, sim)
        )
    else:
        richest = _richest(small, plain, base, coarse)
        sample = fit_whitener(richest, small.weight, small.slices(), groups, held=_held(small, base.prediction))
        systems = [r.system for r in sim.problem.records]
        whiten = spread_whitener(sample, groups, sim.weight, sim.slices(), systems, _held(sim, rough.prediction))
    search = Search(sim, whiten, fit(sim, whiten, (), (), rough.theta, np.zeros(0)))
    costs = {f.ids: _whitened_cost(small, sample, f) for f in coarse}
    fine = sorted(coarse, key=lambda f: (costs[f.ids], f.ids))
    reference = _whitened_cost(small, sample, base)
    best_gain = max(reference - costs[fine[0].ids], 0.0) if fine else 0.0
    chosen_fits = [
        f for k, f in enumerate(fine) if k < LEAST_FITS or (k < REFINED and reference - costs[f.ids] > REFINED_SHARE * best_gain)
    ]

    # the stick-slip family is judged by its shape as well: its best member stays at hand
    kin = [f for f in fine if f.ids[0] in FAMILY][:1]
    chosen_fits += [f for f in kin if all(f is not c for c in chosen_fits)]

    def refined(c: Fit) -> Fit:
        theta = search.base.theta.copy()
        theta[chosen] = c.theta
        done = fit(sim, whiten, c.ids, c.free, theta, c.values)
        if done.cost > search.base.cost:
            # a fit that ends above the base it contains is stuck far away: once more from near the base
            near = [starts(c.free)[0][i] if not f.parameter.shape else v for i, (f, v) in enumerate(zip(c.free, c.values, strict=True))]
            done = min(done, fit(sim, whiten, c.ids, c.free, search.base.theta, np.array(near)), key=lambda f: f.cost)
        advance(1)
        return done

    for f in _each(refined, chosen_fits, workers):
        search.fits[f.ids] = f
    warm = {c.ids[0]: c.values for c in coarse}
    for size in range(2, max_effects + 1):
        if not search.fits or not _room(search, size - 1, noise_n, partner_share):
            break
        _combine(search, ids, size, warm, workers)
        advance(len(ids) / max(max_effects - 1, 1))
    return search


def _reduced(sim: Simulator) -> Simulator:
    """Return the simulator of representative runs."""
    problem = representatives(sim.problem)
    kept = {r.run_id for r in problem.records}
    push = None
    if sim.push is not None:
        parts = [sim.push[s] for r, s in zip(sim.problem.records, sim.slices(), strict=True) if r.run_id in kept]
        push = np.concatenate(parts)
    return Simulator(problem, sim.mechanics, sim.fixed, push)


def _room(search: Search, size: int, noise_n: float, partner_share: float) -> bool:
    """Whether the best model of ``size`` effects leaves enough for one more."""
    leaders = search.leaders(size)
    if not leaders:
        return False
    w = search.sim.weight

    def power(f: Fit) -> float:
        return float(np.sum(w * f.residual**2) / max(w.sum(), 1.0))

    left, base = min(power(f) for f in leaders[:3]), power(search.base)
    over = left - noise_n**2
    return over > 0.1 * noise_n**2 and over > min(partner_share * max(base - left, 0.0), 0.4 * noise_n**2)


def _each(work: Callable[[T], R], items: Sequence[T], workers: int) -> list[R]:
    """Return ``work`` of each item in order; threads share the data, the kernels release the lock."""
    if workers < 2:
        return [work(item) for item in items]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(work, items))


def _held(sim: Simulator, prediction: Array) -> NDArray[np.bool_]:
    """Return where the model holds the output, shape (samples,)."""
    held = np.abs(np.diff(prediction, prepend=prediction[:1])) < 1e-9
    held[[s.start for s in sim.slices()]] = False
    return held


def _whitened_cost(sim: Simulator, whiten: Whitener, f: Fit) -> float:
    r = whiten(f.residual)
    return 0.5 * float(r @ r)


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


def _combine(search: Search, ids: Sequence[str], size: int, warm: dict[str, Array], workers: int) -> None:
    """Extend the best models of ``size - 1`` effects by the partners whose linearised gain is largest."""
    sim, whiten = search.sim, search.whiten
    levels = replace(whiten, holds=())
    for leader in search.leaders(size - 1)[: PAIR_LEADERS if size == 2 else 1]:
        others = [
            i for i in ids if i in warm and i not in leader.ids and tuple(sorted((*leader.ids, i))) not in search.fits
        ]

        # far from the optimum whole holds are off, and that is what a linear step sees best: their levels count here
        along = replace(leader, cost=_whitened_cost(sim, levels, leader))

        def gain(effect_id: str, leader: Fit = along) -> tuple[float, str, Array]:
            found, start = screen(sim, levels, leader, (effect_id,), warm[effect_id])
            return -found, effect_id, start

        def joined(partner: tuple[float, str, Array], leader: Fit = leader) -> Fit:
            _, effect_id, start = partner
            free = (*leader.free, *_without(free_parameters((effect_id,), sim.problem.systems), leader.free))
            return fit(
                sim, whiten, (*leader.ids, effect_id), free, leader.theta, np.concatenate((leader.values, start))
            )

        partners = sorted(_each(gain, others, workers), key=lambda p: p[:2])[:PAIR_PARTNERS]
        for f in _each(joined, partners, workers):
            search.fits[tuple(sorted(f.ids))] = f

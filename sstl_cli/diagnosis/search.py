"""Which effects explain the gap: every candidate refitted in the simulator, alone and combined."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis import again, by_run, ending, ends, hearing, nameless, shared, sticking, usual
from sstl_cli.diagnosis import noise as noise_of
from sstl_cli.diagnosis.combining import combine
from sstl_cli.diagnosis.constants import (
    ALIVE_NATS,
    BASE_ITERATIONS,
    COARSE_ITERATIONS,
    COMBINED,
    DECIDES_NATS,
    FITTED,
    LEADERS,
    MAX_ITERATIONS,
    PARTNERS,
    PROMISING,
    SCREENED,
    SHORT_ITERATIONS,
)
from sstl_cli.diagnosis.evidence import Weighed, weigh
from sstl_cli.diagnosis.fit import Fit, first_theta, fit, held, normal_equations, settle
from sstl_cli.diagnosis.found import NOTHING, Search, deepest, each
from sstl_cli.diagnosis.free import as_effects
from sstl_cli.diagnosis.hypotheses import GAIN, Hypothesis, as_changes, at_known_load, by_usual_law, of_other_laws
from sstl_cli.diagnosis.louder import unalike
from sstl_cli.diagnosis.records import representatives
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.starts import by_gain, grid, screen, speeds, starting, widths
from sstl_cli.diagnosis.whitening import Whitener, white
from sstl_cli.physics.effect import NOMINAL_THETA, TRANSITION
from sstl_cli.physics.effects import get

Array = NDArray[np.float64]
SIZES = ("singles", "pairs", "triples")


def run(
    sim: Simulator,
    ids: Sequence[str],
    theta0: Array,
    max_effects: int,
    advance: Callable[[float], None] = lambda _: None,
    workers: int = 1,
    passed: Callable[[str], bool] = lambda _: False,
) -> Search:
    """Fit the base, every candidate, and combinations of up to ``max_effects`` effects.

    First unwhitened and on representative runs, because a whitened fit from a poor start gets stuck; then with the noise
    that the richest model leaves, each model by its own phases. ``passed`` says whether combinations have to be left out (see core.deadline).
    """
    starts = _as_known(sim, [h for i in ids for h in starting(i, sim.problem.systems)])
    found, first_round = _begun(sim, starts, theta0, advance, workers)
    lead = max((found.base.cost - f.cost for f in first_round), default=0.0)
    least = lead - max(ALIVE_NATS, (1.0 - PROMISING) * lead)

    def alone(group: Sequence[Fit]) -> tuple[Weighed, ...]:
        done = _weighed(found, group, least)
        advance(FITTED * len(group) / max(len(starts), 1))
        return done

    groups = [list(g) for _, g in itertools.groupby(sorted(first_round, key=lambda f: f.ids), key=lambda f: f.ids)]
    for done in each(alone, groups, workers):
        found.singles[done[0].ids[0]] = done
    found = _by_the_end(found, {g[0].ids[0]: g for g in groups}, least)
    found = shared.loosened(found, workers)
    most = min(max_effects, len(found.singles))
    for size in range(2, most + 1):
        if passed(SIZES[size - 1]):
            continue
        if not combine(found, size, workers):
            break
        if size == 2:
            found = again.beside_the_best(found, max_effects, workers)
        advance(COMBINED / max(max_effects - 1, 1))
    if not found.combined:
        found = again.beside_the_best(found, max_effects, workers)
    by_run.add(found, max_effects)
    return nameless.beside(usual.beyond(found), max_effects, workers)


def _begun(
    sim: Simulator, starts: Sequence[Hypothesis], theta0: Array, advance: Callable[[float], None], workers: int
) -> tuple[Search, list[Fit]]:
    """Return a search that has its noise and its base, and a first whitened fit of every hypothesis."""
    small = Simulator(representatives(sim.problem), sim.mechanics, sim.fixed, zeros_n=sim.zeros_n)
    chosen = [sim.problem.configs.index(c) for c in small.problem.configs]
    base = fit(small, _plain(small, 1.0), NOTHING, theta0[chosen], np.zeros(0), careful=True)
    spread = max(float(np.sqrt(np.sum(small.weight * base.residual**2) / max(small.weight.sum(), 1.0))), 1e-9)
    rough, theta = _rough(small, starts, base.theta, spread, advance, workers)
    plain = _plain(sim, spread)
    first = fit(sim, plain, NOTHING, _spread(theta0, chosen, theta), np.zeros(0), BASE_ITERATIONS, careful=True)
    slide = sim.phases(first.theta, {}).slide
    predicted = sim.predict_fine(first.theta, {})
    loud = unalike(sim.problem.records, predicted, [slide[s] for s in sim.slices()])
    # beside an accepted model, whose noise is alike for all, a line does not rest
    rests = not sim.problem.scatters and sticking.rests(loud, predicted) > DECIDES_NATS
    sim = replace(sim, problem=replace(sim.problem, records=loud), rests=rests)
    read = measured = noise_of.measured(loud, slide)
    if sim.problem.scatters:
        # what slides show beyond holds is the scatter of the accepted model, which is known
        noise = noise_of.white_only(measured)
    else:
        rich = [
            fit(sim, plain, f.hypothesis, _everywhere(sim, first.theta, chosen, f), f.values, SHORT_ITERATIONS, careful=True)
            for f in _effects_first(rough)[: 2 * LEADERS]
        ]
        # a few runs are a poor judge of which explains most, and what no leader explains the noise would have to take up
        rich = sorted(rich, key=lambda f: f.cost)[:LEADERS]
        sim, first, noise, measured = hearing.heard(sim, [first, *rich], measured)
    return _first_round(Search(sim, noise, measured, settle(sim, noise, first), {}, {}, read=read), rough, chosen, workers)


def _rough(
    small: Simulator, starts: Sequence[Hypothesis], theta: Array, spread_n: float, advance: Callable[[float], None], workers: int
) -> tuple[list[Fit], Array]:
    """Return unwhitened fits of every hypothesis on representative runs, the best first, and the theta of the base there."""
    plain = _plain(small, spread_n)
    base = fit(small, plain, NOTHING, theta, np.zeros(0), BASE_ITERATIONS, careful=True)

    def promise(h: Hypothesis) -> tuple[float, Hypothesis, Array]:
        gain, start = screen(small, base, h)
        advance(SCREENED / max(len(starts), 1))
        return gain, h, start

    promises = sorted(each(promise, starts, workers), key=lambda p: -p[0])

    def coarse(place: int) -> Fit:
        gain, h, start = promises[place]
        near = place < LEADERS or gain > PROMISING * promises[0][0]
        begins = [x for x in ((base.theta, start), by_gain(small, h)) if x is not None]
        done = min(
            (fit(small, plain, h, *x, COARSE_ITERATIONS if near else SHORT_ITERATIONS, careful=True) for x in begins), key=lambda f: f.cost
        )
        advance(FITTED / max(len(starts), 1))
        return done

    return sorted(each(coarse, range(len(promises)), workers), key=lambda f: (f.cost, f.ids)), base.theta


def _effects_first(ordered: Sequence[Fit]) -> list[Fit]:
    """Return the first fit of each effect, then the others, in their order: laws and sensors of one effect explain much the same."""
    first: dict[tuple[str, ...], Fit] = {}
    for f in ordered:
        first.setdefault(f.ids, f)
    return [*first.values(), *(f for f in ordered if first[f.ids] is not f)]


def _as_known(sim: Simulator, found: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return hypotheses beside what the simulator says: of the load, and of effects that it contains, each once."""
    known = [as_changes(at_known_load(h) if sim.load_known else h, sim.fixed) for h in found]
    return [h for h in dict.fromkeys(known) if h.strengths]


def _first_round(found: Search, rough: Sequence[Fit], chosen: Sequence[int], workers: int) -> tuple[Search, list[Fit]]:
    """Return every rough fit begun anew with the noise, and the search with the likeliest base that this has shown."""
    sim, noise, base = found.sim, found.noise, found.base

    def begun(f: Fit) -> Fit:
        start = fit(sim, base.whiten, f.hypothesis, _everywhere(sim, base.theta, chosen, f), f.values, 0)
        wide = [fit(sim, base.whiten, f.hypothesis, base.theta, v, SHORT_ITERATIONS) for v in widths(sim, noise, f)]
        start = min((start, *wide), key=lambda f: f.cost)
        jumps = [fit(sim, base.whiten, f.hypothesis, base.theta, v, 0) for v in speeds(f)] if sim.rests else []
        start = min((settle(sim, noise, x, 0) for x in (start, *jumps)), key=lambda f: f.cost) if jumps else start
        # what acts along the line, or makes all of it late, has several valleys, which the unwhitened fit has looked into
        if start.cost > base.cost and not any(x.effect.stage == TRANSITION or x.effect.late_s for x in f.free):
            return _near(found, f, SHORT_ITERATIONS, SHORT_ITERATIONS)
        return _containing(found, settle(sim, noise, start, 1, SHORT_ITERATIONS))

    fits = each(begun, rough, workers)
    likeliest = [f for f in sorted(fits, key=lambda f: f.cost)[:LEADERS] if f.cost < base.cost]
    least = deepest(sim, noise, base, likeliest)
    if least is base:
        return found, fits
    found = replace(found, base=least)
    return found, each(lambda f: _containing(found, f), fits, workers)


def _containing(found: Search, f: Fit) -> Fit:
    """Return a fit that is likelier than the base, which it contains, or the better one of it and another from near the base."""
    return f if f.cost < found.base.cost else min(f, _near(found, f, COARSE_ITERATIONS, SHORT_ITERATIONS), key=lambda x: x.cost)


def _plain(sim: Simulator, scale_n: float) -> Whitener:
    return white(scale_n, sim.weight, [s.start for s in sim.slices()])


def _spread(theta: Array, chosen: Sequence[int], own: Array) -> Array:
    out = theta.copy()
    out[list(chosen)] = own
    return out


def _everywhere(sim: Simulator, theta: Array, chosen: Sequence[int], f: Fit) -> Array:
    """Return theta of all configurations beside a fit of a few: as it is without the fit, or as it goes with its gain where that leaves less."""
    without = _spread(theta, chosen, f.theta)
    if f.ids != GAIN or len(chosen) == len(theta):
        return without
    effects = as_effects(f.free, f.values)
    with_gain = _spread(first_theta(sim, np.full(len(theta), NOMINAL_THETA), effects), chosen, f.theta)
    return min((without, with_gain), key=lambda t: float(np.sum(sim.weight * (sim.y - sim.predict(t, effects)) ** 2)))


def _weighed(found: Search, begun: Sequence[Fit], least: float) -> tuple[Weighed, ...]:
    """Return the hypotheses of one effect, the most evident first; those that gain more than the ``least`` (nats) refitted by their own phases."""
    sim, base = found.sim, found.base
    alive = [base.cost - f.cost > least for f in begun]
    done = [_settled(found, f, judged=True) if a else f for f, a in zip(begun, alive, strict=True)]
    weighed = [weigh(sim, f, base) for f in done]
    effect_id = begun[0].ids[0]
    beside = of_other_laws(effect_id)
    usual = [d for d in zip(done, alive, strict=True) if not any(x.parameter.name in beside for x in d[0].free)]
    whole, followed = max(usual, key=lambda d: len(d[0].hypothesis.strengths), default=(begun[0], False))
    if followed and not get(effect_id).variants and len(whole.hypothesis.strengths) > 1:
        for h, values, theta in _subsets(sim, whole):
            start = fit(sim, whole.whiten, h, theta, values, 0)
            weighed.append(weigh(sim, _settled(found, start), base))
    looser = [ends.apart(found, w.fit) for w in weighed if base.cost - w.fit.cost > least]
    weighed += [weigh(sim, f, base) for f in looser if f is not None]
    return tuple(sorted(weighed, key=lambda w: -w.evidence))


def _by_the_end(found: Search, groups: Mapping[str, Sequence[Fit]], least: float) -> Search:
    """Return the search with more friction at the end than is accepted acting on all that arrives there, or on the line alone, as is likelier.

    What a model left of its record may arise in the line, whose friction at the end holds it back, or behind it.
    """
    group = groups.get(ending.EFFECT, ())
    if not group or not found.sim.left:
        return found
    sim = replace(found.sim, behind=False)
    bends = [found.base.theta] if sim.accepted is None else [sim.accepted]

    def begun(f: Fit) -> Fit:
        starts = [fit(sim, f.whiten, f.hypothesis, theta, f.values, 0) for theta in (f.theta, *bends)]
        return min((settle(sim, found.noise, s, 1, SHORT_ITERATIONS) for s in starts), key=lambda s: s.cost)

    alone = replace(found, sim=sim)
    own = _weighed(alone, [begun(f) for f in group], least)
    if own[0].evidence <= found.singles[ending.EFFECT][0].evidence:
        return found
    return replace(alone, singles={**found.singles, ending.EFFECT: own})


def _settled(found: Search, start: Fit, judged: bool = False) -> Fit:
    done = settle(found.sim, found.noise, start, judged=judged)
    # it contains the base
    return done if done.cost < found.base.cost else min(done, _near(found, done), key=lambda f: f.cost)


def _near(found: Search, shaped: Fit, iterations: int = MAX_ITERATIONS, settled: int = MAX_ITERATIONS) -> Fit:
    """Return a fit from near the base, with the shapes of another: strengths are hardly there at its start."""
    start = grid(shaped.free)[0]
    start = np.array([v if f.parameter.shape else n for f, v, n in zip(shaped.free, shaped.values, start, strict=True)])
    again = fit(found.sim, found.base.whiten, shaped.hypothesis, found.base.theta, start, iterations)
    return settle(found.sim, found.noise, again, 1, settled)


def _subsets(sim: Simulator, whole: Fit) -> list[tuple[Hypothesis, Array, Array]]:
    """Return the subsets of a full fit that may be as evident, with their starting values and theta.

    The cost of holding some parameters at neutral follows from the curvature at the optimum.
    """
    j, configs = whole.whiten(whole.jacobian), len(whole.theta)
    a, _ = normal_equations(sim, j, np.zeros(len(j)))
    a += 1e-9 * np.diag(np.diag(a) + 1e-12)
    neutral = np.array([f.parameter.neutral for f in whole.free])
    rows = []
    for h in _as_known(sim, by_usual_law(whole.ids[0], sim.problem.systems)):
        if len(h.free) == len(whole.free):
            continue
        kept = np.array([f in h.free for f in whole.free])
        fixed = configs + np.flatnonzero(~kept)
        loss, cross = held(a, fixed, neutral[~kept] - whole.values[~kept])
        moved = np.concatenate((whole.theta, whole.values[kept])) - cross
        low = np.array([f.parameter.least for f in h.free])
        high = np.array([f.parameter.most for f in h.free])
        rows.append((loss, h, np.clip(moved[configs:], low, high), moved[:configs]))
    scores = [loss + 0.5 * len(h.strengths) * np.log(len(sim.y)) for loss, h, _, _ in rows]
    order = np.argsort(scores)[:PARTNERS]
    return [rows[i][1:] for i in order]

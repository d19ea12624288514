"""Combinations of effects: which of them promise most, and what stands beside the best."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import ADDS, COARSE_ITERATIONS, EDGE, JOINS_NATS, LEADERS, PAIRS, PARTNERS, SWAPS
from sstl_cli.diagnosis.evidence import Weighed, strengths_charge, weigh
from sstl_cli.diagnosis.fit import Fit, fit, normal_equations, settle
from sstl_cli.diagnosis.found import Search, each
from sstl_cli.diagnosis.hypotheses import Hypothesis, apart
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.starts import grid, screen
from sstl_cli.physics.effect import INSTRUMENT
from sstl_cli.physics.effects import get

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Job:
    """A combination worth fitting: the fit to start from (None: the base), what joins it, and the values that it starts with."""

    promise: float
    leader: Weighed | None
    joining: tuple[Weighed, ...]
    starts: tuple[Array, ...]

    @property
    def ids(self) -> tuple[str, ...]:
        """The effects that it has, in order of name."""
        ids = [i for w in self.joining for i in w.ids]
        return tuple(sorted(ids if self.leader is None else (*self.leader.ids, *ids)))


def combine(found: Search, size: int, workers: int) -> int:
    """Fit the combinations of ``size`` effects that promise most; return how many were fitted."""
    sim, base = found.sim, found.base
    shorter = [w for w in found.ranked() if len(w.ids) == size - 1 and w.evidence > 0.0]
    jobs: dict[tuple[str, ...], _Job] = {}

    def offer(job: _Job) -> None:
        if apart(job.ids) and (job.ids not in jobs or jobs[job.ids].promise < job.promise):
            jobs[job.ids] = job

    for leader in shorter[: LEADERS if size == 2 else 1]:
        others = [w for effect_id, laws in found.singles.items() if effect_id not in leader.ids for w in laws]
        for partner, added, step in _partners(sim, leader, others, workers):
            if added > ADDS:
                offer(_Job(leader.evidence + added, leader, (partner,), (_begin(partner.fit, step),)))
    if size == 2 and shorter:
        for two, promise, steps in _pairs(sim, base, [w for laws in found.singles.values() for w in laws]):
            if promise > shorter[0].evidence + ADDS:
                starts = tuple(_begin(w.fit, step) for w, step in zip(two, steps, strict=True))
                offer(_Job(promise, None, two, starts))

    chosen = sorted(jobs.values(), key=lambda j: -j.promise)[: PAIRS if size == 2 else PARTNERS]
    for w in each(lambda job: _joined(found, job), chosen, workers):
        found.combined[tuple(sorted(w.ids))] = w
    if size == 2:
        # what stands in for one part may let another one stand in for the other
        if _swap(found, workers):
            _swap(found, workers)
        _parted(found, workers)
    return len(chosen)


def _swap(found: Search, workers: int) -> bool:
    """Fit the neighbours of the most evident pair, and return whether one is likelier: a part by another effect, or by another hypothesis of its own.

    To first order, from parts that have each explained as much as they can alone, what looks alike is told apart poorly.
    """
    leader = found.ranked()[0]
    if len(leader.ids) != 2 or leader.evidence <= max(found.best((i,)).evidence for i in leader.ids) + JOINS_NATS:
        return False
    jobs = []
    for part in leader.ids:
        others = _others(found, leader, part)
        kept = _without(found, leader, part) if others else leader
        told = sorted(_partners(found.sim, kept, others, workers), key=lambda p: -p[1])
        jobs += [_Job(leader.evidence, kept, (w,), (_like_part(leader, kept, w),)) for w in _instead(found, [w for w, _, _ in told])]
        told = sorted(_shaped(found.sim, kept, [w for w in others if _alike(part, w.ids[0])], workers), key=lambda p: -p[1])
        jobs += [_Job(leader.evidence, kept, (partner,), (start,)) for partner, _, start in told[:SWAPS]]
    for w in each(lambda job: _joined(found, job), jobs, workers):
        key = tuple(sorted(w.ids))
        if key not in found.combined or w.evidence > found.combined[key].evidence:
            found.combined[key] = w
    return found.ranked()[0] is not leader


def _parted(found: Search, workers: int) -> None:
    """Fit the parts of the leading pairs alone from where they stand there: a fit of its own may have stopped in another valley."""
    pairs = [w for w in found.ranked() if len(w.ids) == 2][:LEADERS]
    jobs = [(part, _without(found, w, next(i for i in w.ids if i != part)).fit) for w in pairs for part in w.ids]

    def alone(job: tuple[str, Fit]) -> Weighed:
        return weigh(found.sim, settle(found.sim, found.noise, job[1], 1), found.base)

    for (part, _), w in zip(jobs, each(alone, jobs, workers), strict=True):
        if w.evidence > found.singles[part][0].evidence:
            found.singles[part] = (w, *found.singles[part])


def _instead(found: Search, promising: Sequence[Weighed]) -> list[Weighed]:
    """Return the hypotheses worth fitting of those that may stand in a part's place, the most promising first: of each effect two.

    The one that promises most beside the rest, and the one that explains most alone: to first order laws of one effect are ranked poorly.
    """
    effects = list(dict.fromkeys(w.ids[0] for w in promising))[:SWAPS]
    first = [next(w for w in promising if w.ids[0] == i) for i in effects]
    alone = [w for i in effects for w in found.singles[i][:1] if any(w is p for p in promising)]
    return [*first, *(w for w in alone if all(w is not f for f in first))]


def _like_part(leader: Weighed, kept: Weighed, other: Weighed) -> Array:
    """Return the start of what stands in the place of a part: with strengths that do most nearly what the part does, all else as it is."""
    does = leader.fit.whiten(leader.fit.prediction - kept.fit.prediction)
    step = np.linalg.lstsq(leader.fit.whiten(other.fit.jacobian[:, 1:]), does, rcond=None)[0]
    return _begin(other.fit, np.asarray(step, np.float64))


def _others(found: Search, leader: Weighed, part: str) -> list[Weighed]:
    """Return the hypotheses that may stand in the place of a part of a pair, and have not been fitted there."""
    (rest,) = (i for i in leader.ids if i != part)
    fitted = {frozenset(w.fit.free) for w in found.combined.values()}
    kept = frozenset(x for x in leader.fit.free if x.effect.id != part)
    return [w for i, laws in found.singles.items() if i != rest and apart((rest, i)) for w in laws if kept | set(w.fit.free) not in fitted]


def _alike(part: str, other: str) -> bool:
    """Whether an effect may look like another one; what one fault of a sensor does, another one may."""
    one, two = get(part), get(other)
    known = part == other or other in one.look_alikes or part in two.look_alikes or not apart((other, part))
    return known or one.stage == two.stage == INSTRUMENT


def _without(found: Search, leader: Weighed, part: str) -> Weighed:
    """Return a combination without one of its effects, the others as they are in it."""
    f = leader.fit
    kept = [k for k, x in enumerate(f.free) if x.effect.id != part]
    h = Hypothesis(tuple(i for i in f.ids if i != part), tuple(f.free[k] for k in kept))
    return replace(leader, fit=fit(found.sim, f.whiten, h, f.theta, f.values[kept], 0))


def _joined(found: Search, job: _Job) -> Weighed:
    """Return the fit of a combination."""
    sim, start = found.sim, found.base if job.leader is None else job.leader.fit
    h, values = start.hypothesis, start.values
    for partner, begin in zip(job.joining, job.starts, strict=True):
        known = dict(zip(partner.fit.free, begin, strict=True))
        more = h.joined(partner.fit.hypothesis)
        values = np.concatenate((values, [known[f] for f in more.free[len(h.free) :]]))
        h = more
    begun = fit(sim, start.whiten, h, start.theta, values, COARSE_ITERATIONS)
    # its leader's law is as far off beside another effect, until that proves otherwise
    done = settle(sim, found.noise, replace(begun, discrepancy=start.discrepancy), 1)
    if job.leader is not None and done.cost > start.cost:
        # it contains its leader: once more from there, with a newcomer that is hardly there, and by its own phases at once
        weak = np.concatenate((start.values, grid(h.free[len(start.free) :])[0]))
        again = replace(fit(sim, start.whiten, h, start.theta, weak, 0), discrepancy=start.discrepancy)
        done = min(done, settle(sim, found.noise, again, 1), key=lambda f: f.cost)
    return weigh(sim, done, found.base, found.parts(h.ids))


def _pairs(sim: Simulator, base: Fit, models: Sequence[Weighed]) -> list[tuple[tuple[Weighed, Weighed], float, tuple[Array, Array]]]:
    """Return the linearised evidence (nats) over the base of every two models that share no effect, with their steps."""
    gram, score, slices = _projected(sim, base, [w.fit.jacobian[:, 1:] for w in models])
    found = []
    for i, j in itertools.combinations(range(len(models)), 2):
        if models[i].ids == models[j].ids:
            continue
        at = np.concatenate((np.arange(slices[i].start, slices[i].stop), np.arange(slices[j].start, slices[j].stop)))
        inner = gram[np.ix_(at, at)]
        step = np.linalg.lstsq(inner + 1e-6 * np.diag(np.diag(inner) + 1e-12), score[at], rcond=1e-10)[0]
        cut = slices[i].stop - slices[i].start
        promise = _promise(0.5 * float(score[at] @ step), models[i], models[j])
        found.append(((models[i], models[j]), promise, (step[:cut], step[cut:])))
    return found


def _partners(sim: Simulator, leader: Weighed, others: Sequence[Weighed], workers: int = 1) -> list[tuple[Weighed, float, Array]]:
    """Return for each other model its linearised evidence (nats) beside a leader, and the step of its parameters.

    Beside its slopes alone stands what all of it does beside the leader: a late sensor shows it later, and what acts along the
    line is not linear.
    """
    f = leader.fit

    def beside(w: Weighed) -> Array:
        both = sim.predict(f.theta, {**w.fit.effects, **f.effects}) - f.prediction
        return np.concatenate((w.fit.jacobian[:, 1:], both[:, None]), axis=1)

    gram, score, slices = _projected(sim, f, each(beside, others, workers))
    found = []
    for w, s in zip(others, slices, strict=True):
        inner = gram[s, s] + 1e-6 * np.diag(np.diag(gram[s, s]) + 1e-12)
        step = np.asarray(np.linalg.lstsq(inner, score[s], rcond=1e-10)[0], np.float64)
        whole = w.fit.values - np.array([x.parameter.neutral for x in w.fit.free])
        found.append((w, _promise(0.5 * float(score[s] @ step), w), step[:-1] + step[-1] * whole))
    return found


def _shaped(sim: Simulator, leader: Weighed, others: Sequence[Weighed], workers: int = 1) -> list[tuple[Weighed, float, Array]]:
    """Return for the models of a sensor that have shapes their linearised evidence (nats) beside a leader, and the start that promises it.

    What a time constant or a knee took up alone, the leader may explain.
    """
    shaped = [w for w in others if any(x.parameter.shape for x in w.fit.free) and all(x.effect.stage == INSTRUMENT for x in w.fit.free)]
    screened = each(lambda w: screen(sim, leader.fit, w.fit.hypothesis), shaped, workers)
    return [(w, _promise(gain, w), start) for w, (gain, start) in zip(shaped, screened, strict=True)]


def _promise(gain: float, *joining: Weighed) -> float:
    """Return what a linearised gain (nats) of models is worth less the charge of their strengths."""
    k = sum(len(w.fit.hypothesis.strengths) for w in joining)
    return max(gain, 0.0) - strengths_charge(k, 2.0 * max(gain, 0.0))


def _projected(sim: Simulator, f: Fit, answers: Sequence[Array]) -> tuple[Array, Array, list[slice]]:
    """Return the normal equations of models' answers, one column each, beside a fit that follows what it can, and their places.

    All of them cost one pass through the fit's filter.
    """
    ends = np.cumsum([x.shape[1] for x in answers])
    slices = [slice(int(e) - x.shape[1], int(e)) for e, x in zip(ends, answers, strict=True)]
    if not answers:
        return np.zeros((0, 0)), np.zeros(0), slices
    columns = f.whiten.beside(f.residual, np.concatenate([f.jacobian, *answers], axis=1))
    r, known, rest = columns[:, 0], columns[:, 1 : 2 + len(f.free)], columns[:, 2 + len(f.free) :]
    a0, b0 = normal_equations(sim, known, r)
    a0 += 1e-9 * np.diag(np.diag(a0) + 1e-12)
    bends = (sim.config[:, None] == np.arange(len(f.theta))) * known[:, :1]
    own = np.concatenate((bends, known[:, 1:]), axis=1).T @ rest
    follow = np.linalg.solve(a0, np.column_stack((b0, own)))
    return rest.T @ rest - own.T @ follow[:, 1:], rest.T @ r - own.T @ follow[:, 0], slices


def _begin(f: Fit, step: Array) -> Array:
    """Return the start of a partner: its strengths by the linear step from neutral, its shapes as they are alone."""
    values = []
    for x, value, s in zip(f.free, f.values, step, strict=True):
        p = x.parameter
        least = EDGE * x.width * (1.0 if p.high > p.neutral else -1.0)
        moved = p.neutral + (float(s) if abs(s) > abs(least) else least)
        values.append(float(value) if p.shape else float(np.clip(moved, p.least, p.most)))
    return np.array(values)

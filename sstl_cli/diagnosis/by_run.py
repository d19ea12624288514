"""What differs from run to run, friction or a sensor's zero: its spread is fitted, and each run's own is what it shows.

A mixed model (Harville 1977): a normal part of each run beside theta of its configuration. Linear in both, its likelihood has a
closed form for each spread. A pulley, or a gain of one system, shows in the same differences between runs of a bend, by
fewer numbers: without this rival it would be sure of whatever friction does. What all runs of one system in a bend have in common
against those of the other speaks for scatter as far as chance may give it, and no further (see by_chance).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import fdtri, gammaincinv, ndtr

from sstl_cli.diagnosis.constants import DECIDES_NATS, EACH_ROUNDS, FEWEST_CONTRASTS, HALF, LEADERS, THETA_HIGH, THETA_LOW
from sstl_cli.diagnosis.evidence import Weighed, strengths_charge
from sstl_cli.diagnosis.fit import Fit, fit, settle
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.free import RUNS, Free
from sstl_cli.diagnosis.hypotheses import Hypothesis
from sstl_cli.diagnosis.records import Record
from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]
# what is held out of such a model
OWN = "nothing: what a run has of its own is fitted to it"
FRICTION, OUTPUT, INPUT = (Free(RUNS, p) for p in RUNS.parameters)
EFFECTS = {FRICTION: "friction_drift", OUTPUT: "zero_drift", INPUT: "zero_drift"}


def scatter(kind: Free) -> Hypothesis:
    """Return the hypothesis that something differs from run to run."""
    return Hypothesis((EFFECTS[kind],), (kind,))


def contrasts(sim: Simulator) -> int:
    """Return how many differences there are between runs of one system in one configuration."""
    return len(sim.problem.records) - len({(r.config, r.system) for r in sim.problem.records})


def add(found: Search, most: int) -> None:
    """Add what differs from run to run to what was found: on the base, and beside the leading effects.

    Parameters
    ----------
    most : int
        How many effects may stand together.
    """
    if found.sim.scatters:
        return
    if contrasts(found.sim) < FEWEST_CONTRASTS:
        _add_untold(found)
        return
    leaders = [w for w in found.ranked() if len(w.ids) == 1 and w.evidence > 0.0][:LEADERS] if most > 1 else []
    for w in _beside(found, Weighed(found.base, 0.0, 0.0)):
        effect = w.ids[0]
        found.singles[effect] = tuple(sorted((*found.singles[effect], w), key=lambda x: -x.evidence))
    for leader in leaders:
        for w in _beside(found, leader):
            key = tuple(sorted(w.ids))
            if key not in found.combined or w.evidence > found.combined[key].evidence:
                found.combined[key] = w


def _add_untold(found: Search) -> None:
    """Add a zero that differs from run to run where each bend was recorded once: as likely as the best law that stays, if not less.

    By itself it may be likelier than any zero with a law; whether it is the run or the bend that a zero goes with nobody can tell.
    """
    systems = [r.system for r in found.sim.problem.records]
    effect, others = EFFECTS[OUTPUT], [w.evidence for k, v in found.singles.items() if k != EFFECTS[OUTPUT] for w in v]
    if effect not in found.singles or min(systems.count(s) for s in systems) < 2:
        return
    alone = Weighed(found.base, 0.0, 0.0)
    tried = [w for kind in (OUTPUT, INPUT) if (w := _weighed(found, alone, kind, told=False)) is not None]
    most = max(others, default=0.0) - HALF * DECIDES_NATS
    capped = [replace(w, evidence=min(w.evidence, most)) for w in tried]
    found.singles[effect] = tuple(sorted((*found.singles[effect], *capped), key=lambda x: -x.evidence))


def _beside(found: Search, on: Weighed) -> list[Weighed]:
    """Return a model beside which something differs from run to run, one for each thing that may and is asked for."""
    kinds = [kind for kind, effect in EFFECTS.items() if effect in found.singles and effect not in on.ids]
    return [w for kind in kinds if (w := _weighed(found, on, kind)) is not None]


def column(sim: Simulator, f: Fit, kind: Free) -> Array:
    """Return what one unit of a run's own does to its output, shape (samples,)."""
    if kind is FRICTION:
        return np.asarray(f.jacobian[:, 0] * f.theta[sim.config])
    return np.ones(len(sim.y)) if kind is OUTPUT else -sim.by_input(f.theta, f.effects)


@dataclass(frozen=True)
class Told:
    """What each run tells (shape (runs,) each): of its own part ``own``, of theta ``theta``, of both ``both``, and their scores.

    ``place`` and ``system`` are the indices of its configuration and of its system.
    """

    own: Array
    theta: Array
    both: Array
    own_score: Array
    theta_score: Array
    place: NDArray[np.int64]
    system: NDArray[np.int64]


@dataclass(frozen=True)
class _Parted:
    """What runs have of their own: its ``spread``, each run's ``part`` (shape (runs,)), by how much theta moves, and what that gains (nats)."""

    told: Told
    spread: float
    part: Array
    shift: Array
    gain: float


def _weighed(found: Search, on: Weighed, kind: Free, told: bool = True) -> Weighed | None:
    """Return a model beside which one thing differs from run to run; None where no run tells of it.

    Parameters
    ----------
    told : bool
        Whether runs of a bend tell what they have in common from what differs.
    """
    sim, base = found.sim, on.fit
    own = column(sim, base, kind)
    said = _parted(sim, base, kind, own, base.residual)
    if said is None:
        return None
    common = systematic(said.told) if told else 0.0
    if said.gain - common > DECIDES_NATS:
        at, said = _each_simulated(found, base, said, kind)
        # the linear answer of what is in common may be more than what the runs' own, simulated, gain in all
        common = _in_common(found, base) if kind is FRICTION else min(common, said.gain)
    else:
        moved = base.jacobian[:, 0] * said.shift[sim.config] + own * said.part[sim.run]
        at = replace(base, prediction=base.prediction + moved, residual=base.residual - moved)
    f = replace(
        at,
        hypothesis=base.hypothesis.joined(scatter(kind)),
        theta=base.theta + said.shift,
        values=np.append(base.values, said.spread),
        cost=base.cost - said.gain,
        jacobian=np.column_stack((at.jacobian, column(sim, replace(at, theta=base.theta), kind) * (said.part / said.spread)[sim.run])),
    )
    scattered = by_chance(sim, said.gain, common)
    return Weighed(f, on.gain + said.gain, on.evidence + scattered - strengths_charge(1, 2.0 * max(scattered, 0.0)))


def by_chance(sim: Simulator, gain: float, common: float) -> float:
    """Return what is left of a gain (nats) without what runs of a system in a bend have in common beyond what chance gives them.

    Chance gives a contrast between systems as much as one within on average, and at 49 to 1 no more than so many times that (the F
    ratio of Fisher 1925): few contrasts say little of how large the others may be.
    """
    records = sim.problem.records
    within = contrasts(sim)
    between = len(records) - within - len({r.config for r in records})
    most = float(fdtri(between, within, -np.expm1(-DECIDES_NATS))) if between > 0 and within > 0 else 0.0
    return gain - max(common - max(gain - common, 0.0) * most * between / max(within, 1), 0.0)


def _parted(sim: Simulator, at: Fit, kind: Free, own: Array, residual: Array) -> _Parted | None:
    """Return what runs most likely have of their own beside a model that leaves a residual (N); None where no run tells of it."""
    z, c, j = at.whiten.beside(residual, np.column_stack((own, at.jacobian[:, 0]))).T
    sums = (np.bincount(sim.run, x, len(sim.problem.records)).astype(np.float64) for x in (c * c, j * j, c * j, c * z, j * z))
    own_told, theta_told, both, own_score, theta_score = sums
    place = np.array([r.config for r in sim.problem.records])
    system = np.array([sim.problem.systems.index(r.system) for r in sim.problem.records])
    told = Told(own_told, theta_told, both, own_score, theta_score, place, system)
    # from what the noise of one run hides to where it has no meaning
    lowest, most = 0.5 / max(float(np.sqrt(told.own.max())), np.finfo(float).tiny), kind.parameter.most
    if lowest >= most:
        return None
    bounds = (float(np.log(lowest)), float(np.log(most)))
    best = minimize_scalar(lambda x: -gain_of(float(np.exp(x)), told)[0], bounds=bounds, method="bounded")
    spread = float(np.exp(best.x))
    gain, part, shift = gain_of(spread, told)
    return _Parted(told, spread, part, shift, gain)


def _each_simulated(found: Search, base: Fit, said: _Parted, kind: Free) -> tuple[Fit, _Parted]:
    """Return a model simulated with what each run has of its own, and what runs then have: a line slides and holds by it, not in proportion.

    Gauss-Newton steps from where the linear answer leads; the likeliest of them.
    """
    alone = each_alone(found.sim) if kind is FRICTION else found.sim
    here = best = _simulated(found, alone, base, said, kind)
    for _ in range(EACH_ROUNDS - 1):
        at, parted = here
        again = _parted(found.sim, at, kind, *_linear(found.sim, base, at, parted, kind))
        if again is None:
            break
        here = _simulated(found, alone, base, again, kind)
        best = max(best, here, key=lambda x: x[1].gain)
    return best


def _linear(sim: Simulator, base: Fit, at: Fit, said: _Parted, kind: Free) -> tuple[Array, Array]:
    """Return what one unit of a run's own does about a simulated model, and what is left (N) without any and with theta of the base."""
    if kind is FRICTION:
        # every run has a theta, of which its own friction is a part
        own = column(sim, replace(at, theta=base.theta), kind)
        return own, at.residual + at.jacobian[:, 0] * (at.theta - base.theta[said.told.place])[sim.run]
    own = column(sim, at, kind)
    return own, at.residual + at.jacobian[:, 0] * (at.theta - base.theta)[sim.config] + own * said.part[sim.run]


def _simulated(found: Search, alone: Simulator, base: Fit, said: _Parted, kind: Free) -> tuple[Fit, _Parted]:
    """Return a model where each run has what is said of it, and the same with what that gains as simulated.

    Parameters
    ----------
    alone : Simulator
        Of friction, the one in which every run has a theta of its own.
    """
    place = said.told.place
    if kind is FRICTION:
        own, theta = alone, base.theta[place] * (1.0 + said.part) + said.shift[place]
    else:
        own, theta = _without(alone, kind, said.part), base.theta + said.shift
    at = fit(own, base.whiten, base.hypothesis, np.clip(theta, THETA_LOW, THETA_HIGH), base.values, 0 if kind is FRICTION else EACH_ROUNDS)
    at = settle(own, found.noise, replace(at, discrepancy=base.discrepancy), 0)
    if kind is OUTPUT:
        at = replace(at, prediction=at.prediction + said.part[found.sim.run])
    differ = 0.5 * float(np.sum((said.part / said.spread) ** 2))
    return at, replace(said, gain=base.cost - at.cost - differ + charged(said.spread, said.told))


def _without(sim: Simulator, kind: Free, part: Array) -> Simulator:
    """Return a simulator whose records are without the zeros (N, shape (runs,)) that runs have of their own."""

    def cleared(r: Record, zero_n: float) -> Record:
        if kind is INPUT:
            return replace(r, u=r.u - zero_n)
        again = tuple(replace(s, output_n=s.output_n - zero_n) for s in r.again)
        return replace(r, y=r.y - zero_n, start_n=r.start_n - zero_n, again=again)

    records = tuple(cleared(r, float(z)) for r, z in zip(sim.problem.records, part, strict=True))
    return replace(sim, problem=replace(sim.problem, records=records))


def _in_common(found: Search, base: Fit) -> float:
    """Return what one friction for all runs of each system in each configuration gains (nats), simulated as well."""
    records = found.sim.problem.records
    groups = sorted({(r.config, r.system) for r in records})
    shared = _divided(found.sim, [groups.index((r.config, r.system)) for r in records])
    at = fit(shared, base.whiten, base.hypothesis, base.theta[[config for config, _ in groups]], base.values, EACH_ROUNDS)
    return max(base.cost - settle(shared, found.noise, replace(at, discrepancy=base.discrepancy), 0).cost, 0.0)


def each_alone(sim: Simulator) -> Simulator:
    """Return a simulator in which every run has a theta of its own."""
    return _divided(sim, range(len(sim.problem.records)))


def _divided(sim: Simulator, places: Sequence[int]) -> Simulator:
    """Return a simulator whose runs are in other configurations, one of each run."""
    records = tuple(replace(r, config=place) for r, place in zip(sim.problem.records, places, strict=True))
    first = [list(places).index(i) for i in range(max(places) + 1)]
    names = tuple(records[i].raw.run_id for i in first)
    accepted = None if sim.accepted is None else sim.accepted[[sim.problem.records[i].config for i in first]]
    return replace(sim, problem=replace(sim.problem, records=records, configs=names), accepted=accepted)


def gain_of(spread: float, told: Told) -> tuple[float, Array, Array]:
    """Return what a spread gains (nats), each run's own part (shape (runs,)), and by how much theta moves (shape (configurations,)).

    The likelihood is restricted (Patterson and Thompson 1971): theta is integrated out, of which runs that differ tell less than they
    seem to. With theta at its best the spread would come out too small, by the root of 1 - bends / runs.
    """
    kept = _kept(spread, told)
    score = told.theta_score - told.both * told.own_score * kept
    shift = np.bincount(told.place, score) / _left(kept, told)
    moved = shift[told.place]
    apart = told.own_score - told.both * moved
    part = apart * kept
    gain = moved * told.theta_score - 0.5 * told.theta * moved**2 + 0.5 * apart * part
    return float(gain.sum()) + charged(spread, told), part, shift


def charged(spread: float, told: Told) -> float:
    """Return what a spread costs (nats, below 0) beside what it explains: that runs may differ so, and that they tell less of theta."""
    known = np.maximum(np.bincount(told.place, told.theta), np.finfo(float).tiny)
    less_told = np.log(known / _left(_kept(spread, told), told))
    return 0.5 * float(less_told.sum() - np.log1p(told.own * spread**2).sum())


def _kept(spread: float, told: Told) -> Array:
    """Return the variance of each run's own part that is left where it is told, shape (runs,)."""
    return np.asarray(spread**2 / (1.0 + told.own * spread**2))


def _left(kept: Array, told: Told) -> Array:
    """Return what runs tell of theta beside parts of their own, shape (configurations,)."""
    return np.maximum(np.bincount(told.place, told.theta - told.both**2 * kept), np.finfo(float).tiny)


def systematic(told: Told) -> float:
    """Return what one part for all runs of each system in each configuration gains (nats), beside theta: no chance has a hand in it."""
    groups = told.place * (told.system.max() + 1) + told.system
    bend, other = (np.eye(x.max() + 1)[x] for x in (told.place, groups))
    cross = bend.T @ (told.both[:, None] * other)
    thetas = bend.T @ (told.theta[:, None] * bend)
    gram = np.block([[thetas, cross], [cross.T, other.T @ (told.own[:, None] * other)]])
    score = np.concatenate((bend.T @ told.theta_score, other.T @ told.own_score))

    def gained(a: Array, b: Array) -> float:
        return 0.5 * float(b @ np.linalg.lstsq(a, b, rcond=1e-12)[0])

    return gained(gram, score) - gained(thetas, score[: len(thetas)])


def interval(sim: Simulator, spread: float) -> tuple[float, float]:
    """Return the 95 % interval of a spread of as many contrasts, each known well (chi square)."""
    half = 0.5 * contrasts(sim)
    low, high = (2.0 * float(gammaincinv(half, p)) for p in (ndtr(1.96), ndtr(-1.96)))
    return spread * float(np.sqrt(2.0 * half / low)), spread * float(np.sqrt(2.0 * half / high))


def kind_of(f: Fit) -> Free | None:
    """Return what differs from run to run in a fit, None where nothing does."""
    return next((x for x in f.free if x.effect is RUNS), None)


def lasting(found: Search, f: Fit) -> Fit:
    """Return a fit without what runs have of their own."""
    kind = kind_of(f)
    if kind is None:
        return f
    rest = Hypothesis(tuple(i for i in f.ids if i != EFFECTS[kind]), tuple(x for x in f.free if x is not kind))
    others = (w.fit for models in found.singles.values() for w in models)
    return next((x for x in others if rest.ids and x.hypothesis == rest), found.base)


def shown(sim: Simulator, f: Fit) -> tuple[Free, dict[str, float]] | None:
    """Return what differs from run to run in a fit, and how much of it each run has; None where nothing does."""
    kind = kind_of(f)
    if kind is None:
        return None
    own, by = column(sim, f, kind), f.jacobian[:, 1 + f.free.index(kind)] * f.values[f.free.index(kind)]
    part = np.bincount(sim.run, own * by) / np.maximum(np.bincount(sim.run, own**2), np.finfo(float).tiny)
    return kind, {r.raw.run_id: float(x) for r, x in zip(sim.problem.records, part, strict=True)}

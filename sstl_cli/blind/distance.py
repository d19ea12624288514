"""How far the truth of a case is from what any model of the catalogue shows, in units of the case's own noise.

Nothing is estimated: the recordings are made again without noise from the opened truth, and followed by the fast model with
the base, with the withheld effects and with every rival. The noise is the one that was drawn. What smoothing can do about
the noise of the input depends on what is known of the movement; both ends are computed: the input known, and not smoothed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.blind.record import Source
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.evidence import weigh
from sstl_cli.diagnosis.fit import Fit, first_theta, fit
from sstl_cli.diagnosis.found import NOTHING
from sstl_cli.diagnosis.hypotheses import Hypothesis, by_usual_law, full
from sstl_cli.diagnosis.records import Record, prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.smoother import CHAIN, STATES, error_of_means
from sstl_cli.diagnosis.starts import screen, starting
from sstl_cli.diagnosis.whitening import Noise, Sensor, Whitener, white, whitener
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, float]]
# rivals that are refitted: those that come nearest in the linear step, and every look-alike
RIVALS, SUBSETS = 6, 2
# of what has no name the nearest rivals are joined by a second effect, and the nearest pair by a third, as a diagnosis would
PAIRED = 3
BASE_ROUNDS, ROUNDS, LAST_ROUNDS = 6, 5, 3
# far below any noise: a reading that stands still would pass for a slow sensor
TICK_N = 1e-6
# column of a smoother's chain that holds the variance of what is new in the value
VARIANCE = STATES * STATES
# a start next to the base keeps this share of the effect
NEAR = 0.05


@dataclass(frozen=True)
class Apart:
    """Squared distances from the truth, the input noise not smoothed and (``known``) the input known.

    The simulator follows other laws than the fast model, which is no evidence for anybody: the distance to the base is
    beyond ``law``, what the base leaves where nothing is withheld, and those to rivals are beyond ``own``, what the withheld
    effects leave in the fast model (beyond ``law`` where it holds no such effect). Where the truth is no candidate, ``joined``
    are the pairs and the triple of candidates that come nearest, the input noise not smoothed.
    """

    base: float
    base_known: float
    rivals: Mapping[str, float]
    rivals_known: Mapping[str, float]
    law: float
    own: float | None
    joined: Mapping[str, float] = field(default_factory=dict)

    @property
    def rival(self) -> str | None:
        """The nearest rival."""
        return min(self.rivals, key=lambda r: (self.rivals[r], r), default=None)


@dataclass(frozen=True)
class Truth:
    """The noise-free session in the fast model, and the whiteners of its exact noise: input not smoothed, and known."""

    sim: Simulator
    source: Source
    effects: Effects
    claimed: Scenario

    def noise(self, known: bool) -> tuple[list[Record], Noise]:
        """Return the records with what is not known of their input, and the noise of the sensors."""
        n, lab = self.source.bench.noise, self.source.bench.lab
        steps = (0.0, 0.0) if lab is None else (lab.step_in_n, lab.step_out_n)
        white_in, white_out = (float(np.hypot(n.white_n, s / np.sqrt(12.0))) for s in steps)
        records, systems = [], self.sim.problem.systems
        if lab is not None and lab.refresh_hz > 0.0:
            # as much as the few readings of a slow sensor tell, spread over all that it repeats
            white_out *= float(np.sqrt(max(1.0 / self.sim.problem.records[0].raw.dt_s / lab.refresh_hz, 1.0)))
        for r in self.sim.problem.records:
            # every sample errs by itself: nothing of one carries over to the next
            law = np.zeros((len(r) * r.factor, CHAIN))
            law[:, VARIANCE] = 0.0 if known else white_in**2 / r.thin
            moves, error = error_of_means(law, r.factor)
            records.append(replace(r, error_n=error, error_law=moves, start_error_n=white_out / float(np.sqrt(r.thin * r.factor))))
        thin = records[0].thin
        out = Sensor(white_out / float(np.sqrt(thin)), n.coloured_n, n.correlation_s)
        into = Sensor(white_in / float(np.sqrt(thin)), 0.0 if known else n.coloured_n, n.correlation_s)
        return records, Noise(dict.fromkeys(systems, into), dict.fromkeys(systems, out), dict.fromkeys(systems, 1.0))

    def whitener(self, around: Fit, known: bool) -> Whitener:
        """Return the whitener of the case's noise by the phases of a fit."""
        records, noise = self.noise(known)
        sim = Simulator(replace(self.sim.problem, records=tuple(records)), self.sim.mechanics, self.sim.fixed)
        return whitener(sim.constants({}, noise), sim.phases(around.theta, around.effects, noise))


def truth_of(source: Source, effects: Effects, claimed: Scenario) -> Truth:
    """Return the noise-free session of a case as the fast model sees it."""
    runs, session = [], {r.run_id: r for r in source.clean(effects)}
    for r in session.values():
        rng = stream(0, "tick", r.run_id)
        still = [c + TICK_N * rng.standard_normal(len(c)) for c in (r.tension_in_n, r.tension_out_n)]
        # how a line that a motion drives is fitted is no matter here
        runs.append(replace(r, tension_in_n=still[0], tension_out_n=still[1], position_in_mm=None, tension_ref_n=None))
    problem = prepare(runs)
    gaps = () if source.bench.lab is None else source.bench.lab.gaps
    problem = replace(problem, records=tuple(_missing(_with_beside(r, session[r.run_id]), gaps) for r in problem.records))
    fixed = {k: v for k, v in claimed.effects.items() if get(k).fitted and get(k).channel == "out"}
    return Truth(Simulator(problem, claimed.rig.mechanics(), fixed), source, effects, claimed)


def _with_beside(r: Record, run: Run) -> Record:
    return replace(r, raw=replace(r.raw, position_in_mm=run.position_in_mm, tension_ref_n=run.tension_ref_n))


def _missing(r: Record, gaps: Sequence[tuple[float, float]]) -> Record:
    """Return a record that says nothing in the stretches that were not recorded."""
    share = (r.time_s - r.raw.time_s[0]) / max(float(r.raw.time_s[-1] - r.raw.time_s[0]), 1e-9)
    weight = r.weight.copy()
    for start, length in gaps:
        weight[(share >= start) & (share <= start + length)] = 0.0
    return replace(r, weight=weight)


def candidates(effects: Effects, excluded: Sequence[str] = (), fixed: Sequence[str] = ()) -> list[str]:
    """Return the effects that a diagnosis fits to the output and that may pass for the withheld ones."""
    return [
        e for e in catalogue() if fitted(e) and e not in effects and e not in excluded and e not in fixed
    ]  # fmt: skip


@dataclass(frozen=True)
class Followed:
    """What a case shows, followed by base, withheld effects and rivals with its noise, the input noise not smoothed."""

    base: Fit
    own: Fit | None
    rivals: Mapping[str, Fit]
    joined: Mapping[str, Fit]

    @property
    def phases_of(self) -> Fit:
        """The fit whose phases say where the noise enters."""
        return self.own or self.base


def follow(truth: Truth, excluded: Sequence[str] = ()) -> Followed:
    """Return the models that follow a case whose effects act on the predicted output; ``excluded`` are no candidates."""
    sim, effects = truth.sim, truth.effects
    start = _plain_base(truth)
    named = tuple(e for e in effects if e not in excluded and fitted(e))
    own = _own(truth, start, named) if named and len(named) == len(effects) else None
    whiten = truth.whitener(own or start, False)
    base = fit(sim, whiten, NOTHING, start.theta, np.zeros(0), BASE_ROUNDS)
    own = None if own is None else _settled(sim, base, own)
    ids = candidates(effects, excluded, tuple(sim.fixed))
    models = {f.ids[0]: _evident(sim, base, f) for f in _rivals(sim, base, ids, _alike(effects))}
    if own is not None and len(named) > 1:
        parts = {e: _without(sim, own, e) for e in named}
        models |= {f"without {e}": f for e, f in parts.items()} | _swapped(
            sim, parts, [*models, *sorted(_alike(effects) & set(ids) - set(models))]
        )
    return Followed(base, own, models, _joined(sim, models, ids) if own is None and effects else {})


def apart(truth: Truth, excluded: Sequence[str] = ()) -> Apart:
    """Return the distances of a case whose effects act on the predicted output; ``excluded`` are no candidates."""
    found = follow(truth, excluded)
    law, law_known = _law(truth) if truth.effects else (0.0, 0.0)
    known = truth.whitener(found.phases_of, True)
    first = {"": found.base, **found.rivals} if found.own is None else {"": found.base, "own": found.own, **found.rivals}
    near = {k: _cost(f) for k, f in first.items()}
    far = {k: _cost(fit(truth.sim, known, f.hypothesis, f.theta, f.values, LAST_ROUNDS)) for k, f in first.items()}
    if found.own is not None:
        # it holds the base: where no start leads below it, the fast model's law adds nothing
        near["own"], far["own"] = min(near["own"], near[""]), min(far["own"], far[""])
    return Apart(
        max(near[""] - law, 0.0),
        max(far[""] - law_known, 0.0),
        {k: max(near[k] - near.get("own", law), 0.0) for k in found.rivals},
        {k: max(far[k] - far.get("own", law_known), 0.0) for k in found.rivals},
        law if truth.effects else near[""],
        near.get("own"),
        {k: max(_cost(f) - law, 0.0) for k, f in found.joined.items()},
    )


def _settled(sim: Simulator, base: Fit, own: Fit) -> Fit:
    """Return the withheld effects refitted with the case's noise, from their own values and from next to the base."""
    near = [
        f.parameter.neutral + NEAR * (v - f.parameter.neutral) if not f.parameter.shape else v
        for f, v in zip(own.free, own.values, strict=True)
    ]
    starts = ((own.theta, own.values), (base.theta, np.array(near)))
    return min((fit(sim, base.whiten, own.hypothesis, theta, values, ROUNDS) for theta, values in starts), key=lambda f: f.cost)


def _plain_base(truth: Truth) -> Fit:
    sim = truth.sim
    plain = white(1.0, sim.weight, [s.start for s in sim.slices()])
    nominal = _theta(truth)
    return fit(sim, plain, NOTHING, first_theta(sim, nominal), np.zeros(0), BASE_ROUNDS)


def _theta(truth: Truth) -> Array:
    return np.array([truth.source.bench.theta[int(c[1:]) - 1] for c in truth.sim.problem.configs])


def _law(truth: Truth) -> tuple[float, float]:
    """Return what the base leaves of the simulator where nothing is withheld: input noise not smoothed, and known."""
    bare = truth_of(truth.source, {}, truth.claimed)
    start = _plain_base(bare)
    found = []
    for known in (False, True):
        done = fit(bare.sim, bare.whitener(start, known), NOTHING, start.theta, np.zeros(0), BASE_ROUNDS)
        found.append(_cost(done))
    return found[0], found[1]


def fitted(effect_id: str) -> bool:
    """Whether the diagnosis fits an effect to the output."""
    return effect_id in catalogue() and get(effect_id).fitted and get(effect_id).channel == "out"


def _cost(f: Fit) -> float:
    return 2.0 * f.cost - f.whiten.log_det


def _alike(effects: Effects) -> set[str]:
    return {a for e in effects if e in catalogue() for a in get(e).look_alikes}


def _own(truth: Truth, base: Fit, named: Sequence[str]) -> Fit | None:
    """Return the withheld effects fitted to what they show, from the values that they were drawn with or from the base."""
    sim, effects, h, around = truth.sim, truth.effects, NOTHING, base
    for e in named:
        more = full(e, sim.problem.systems)
        if not more.strengths:
            return None
        h = h.joined(more)
        around = _added(sim, around, more)
    drawn = [effects.get(f.effect.id, {}).get(f.parameter.name, f.parameter.neutral) for f in h.free]
    values = np.clip(drawn, [f.parameter.least for f in h.free], [f.parameter.most for f in h.free])
    return min(fit(sim, base.whiten, h, _theta(truth), values, ROUNDS), around, key=lambda f: f.cost)


def _added(sim: Simulator, around: Fit, h: Hypothesis) -> Fit:
    """Return a fit with one more hypothesis in it, from its best linear step."""
    _, start = screen(sim, around, h)
    joined = around.hypothesis.joined(h)
    return fit(sim, around.whiten, joined, around.theta, np.concatenate((around.values, start)), ROUNDS)


def _rivals(sim: Simulator, base: Fit, ids: Sequence[str], alike: set[str]) -> list[Fit]:
    """Return the rivals fitted with everything free: those that promise most, and every look-alike."""
    screened = []
    for e in ids:
        tries = [(*screen(sim, base, h), h) for h in starting(e, sim.problem.systems)]
        if tries:
            screened.append((e, *max(tries, key=lambda t: t[0])))
    screened.sort(key=lambda s: -s[1])
    return [fit(sim, base.whiten, h, base.theta, start, ROUNDS) for i, (e, _, start, h) in enumerate(screened) if i < RIVALS or e in alike]


def _evident(sim: Simulator, base: Fit, whole: Fit) -> Fit:
    """Return the most evident hypothesis of a rival, as the diagnosis takes it: what moves one sensor needs not four."""
    best = [whole]
    if not get(whole.ids[0]).variants and len(whole.hypothesis.strengths) > 1:
        usual = by_usual_law(whole.ids[0], sim.problem.systems)
        # a rival by a law beside the usual one has none of its parameters
        fewer = [h for h in usual if len(h.free) < len(whole.free) and all(f in whole.free for f in h.free)]
        begun = [_held(sim, whole, h) for h in fewer]
        best += [fit(sim, whole.whiten, f.hypothesis, f.theta, f.values, ROUNDS) for f in sorted(begun, key=lambda f: f.cost)[:SUBSETS]]
    return max(best, key=lambda f: weigh(sim, f, base).evidence)


def _held(sim: Simulator, whole: Fit, h: Hypothesis) -> Fit:
    """Return a hypothesis with fewer free parameters, the others at neutral."""
    values = np.array([whole.values[whole.free.index(f)] for f in h.free])
    return fit(sim, whole.whiten, h, whole.theta, values, 1)


def _without(sim: Simulator, own: Fit, effect_id: str) -> Fit:
    h = NOTHING
    for e in own.ids:
        if e != effect_id:
            h = h.joined(full(e, sim.problem.systems))
    begun = _held(sim, own, h)
    return fit(sim, own.whiten, h, begun.theta, begun.values, ROUNDS)


def _swapped(sim: Simulator, parts: Mapping[str, Fit], ids: Sequence[str]) -> dict[str, Fit]:
    """Return for each part of a pair the other part with the effect that replaces it best."""
    found = {}
    for lost, kept in parts.items():
        done = _with_best(sim, kept, ids)
        found[f"{'+'.join(done.ids)} for {lost}"] = done
    return found


def _joined(sim: Simulator, rivals: Mapping[str, Fit], ids: Sequence[str]) -> dict[str, Fit]:
    """Return the nearest rivals, each with the effect that adds most to it, and the nearest of these pairs with a third."""
    first = sorted(rivals.values(), key=_cost)[:PAIRED]
    pairs = [_with_best(sim, f, [e for e in ids if e not in f.ids]) for f in first]
    nearest = min(pairs, key=_cost, default=None)
    more = [] if nearest is None else [_with_best(sim, nearest, [e for e in ids if e not in nearest.ids])]
    found: dict[str, Fit] = {}
    for f in sorted((*pairs, *more), key=_cost):
        found.setdefault("+".join(sorted(f.ids)), f)
    return found


def _with_best(sim: Simulator, kept: Fit, ids: Sequence[str]) -> Fit:
    """Return a fit with the effect in it that promises most beside what it has, from its best linear step."""
    tries = [(*screen(sim, kept, h), h) for e in ids for h in starting(e, sim.problem.systems)]
    _, start, h = max(tries, key=lambda t: t[0])
    joined = kept.hypothesis.joined(h)
    return fit(sim, kept.whiten, joined, kept.theta, np.concatenate((kept.values, start)), ROUNDS)

"""What was found, as numbers: one row a candidate, one row a log. All that a verdict is made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from sstl_cli.diagnosis import nameless, sticking
from sstl_cli.diagnosis.constants import DECIDES_NATS, EXAMINED
from sstl_cli.diagnosis.evidence import Weighed, inverse
from sstl_cli.diagnosis.fit import Fit, normal_equations
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.heldout import blocks
from sstl_cli.diagnosis.misfit import rms_n
from sstl_cli.diagnosis.noise import floor_n, strain
from sstl_cli.diagnosis.records import content
from sstl_cli.diagnosis.residuals import Leftover, leftover
from sstl_cli.diagnosis.rounding import at_least_rounding
from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]
Ids = tuple[str, ...]
OUTPUT, RECORDER, BESIDE = "output", "recorder", "beside"


@dataclass(frozen=True)
class CandidateRow:
    """One candidate: effects, channel, gain and evidence over the base (nats), and what it leaves.

    ``drop_one`` is its evidence over the best model that lacks one of its effects; ``unstable`` how far its parameters
    differ between two halves of the runs (squared, over what noise allows); ``share`` the part of the squared error that a
    fault of the recorder carries, by which an error beside the output shrinks, or which a model of the output removes
    of what is reducible. ``held`` is how much of that it may at most remove of what was held out, None where nothing was.
    """

    ids: tuple[str, ...]
    kind: str
    strengths: int
    gain: float
    evidence: float
    drop_one: float
    chi2: float
    worst_z: float
    mean_z: float
    outside: int
    unstable: float
    share: float
    held: float | None = None


@dataclass(frozen=True)
class LogRow:
    """One log: samples after the analysis, and what base and best model leave.

    ``strain`` is by how much the noise had to leave what was measured (see noise.strain), ``jumps`` the evidence that the output
    rests where it should slide (see sticking.rests), ``wanders`` that what is slow in it lasts longer than noise of a sensor
    (see noise.likely), ``grown`` the share of the squared error beyond the noise that a model did not leave when it was accepted; None where that
    was not kept.
    """

    samples: int
    systems: int
    configurations: int
    base_chi2: float
    base_worst_z: float
    base_mean_z: float
    best_chi2: float
    best_worst_z: float
    best_mean_z: float
    best_lag_one: float
    best_kurtosis: float
    best_skewness: float
    base_skewness: float
    coloured: float
    noise_ratio: float
    propagates: float
    strain: float | None = None
    jumps: float | None = None
    wanders: float | None = None
    grown: float | None = None

    @property
    def rests(self) -> bool:
        """Whether the output rests and jumps within strokes."""
        return (self.jumps or 0.0) > DECIDES_NATS


@dataclass(frozen=True)
class Rows:
    """The rows of one diagnosis, and the leftovers that they sum up.

    What is ``barred`` is there although it is no candidate, by id with the words for it: found in the readings, which were left out
    for it, or without a name. ``scatters`` says that the simulator is known to leave more in some places than in others.
    """

    log: LogRow
    candidates: tuple[CandidateRow, ...]
    base: Leftover
    best: Leftover
    barred: Mapping[str, str] = field(default_factory=dict)
    scatters: bool = False

    @property
    def named(self) -> Rows:
        """The rows of the candidates alone."""
        return replace(self, candidates=tuple(c for c in self.candidates if not self.barred.keys() & set(c.ids)), barred={})


def leading(rows: Rows) -> CandidateRow | None:
    """Return the most evident model of the output, None where the base is as evident."""
    fitted = [c for c in rows.candidates if c.kind == OUTPUT and c.evidence > 0.0]
    return max(fitted, key=lambda c: c.evidence, default=None)


def best_of(rows: Rows) -> float:
    """Return the largest evidence of any model of the output, at least that of the base (0)."""
    best = leading(rows)
    return 0.0 if best is None else best.evidence


def rows(found: Search, beside: Sequence[CandidateRow] = (), propagates: float = 1.0) -> Rows:
    """Return the rows of a finished search; ``beside`` are candidates of the recorder and of other channels."""
    sim = found.sim
    at_most = at_least_rounding(sim.problem.records, found.measured)
    base = leftover(sim, found.base, at_most)
    ranked = found.every()
    examined = _examined(ranked)
    looked = {w.ids: leftover(sim, w.fit, at_most) for w in examined}
    leading = bool(ranked) and ranked[0].evidence > 0.0
    best = looked[ranked[0].ids] if leading else base
    reducible = _reducible(found)
    held = _held(found, examined, reducible)
    candidates = tuple(replace(_candidate(found, w, looked.get(w.ids, base), reducible), held=held.get(w.ids)) for w in ranked)
    noise = [(found.noise.output[s], found.measured.output[s]) for s in found.noise.output]
    log = LogRow(
        _independent(found, base.samples),
        len(sim.problem.systems),
        len(sim.problem.configs),
        base.chi2,
        base.worst().z,
        _means(base),
        best.chi2,
        best.worst().z,
        _means(best),
        best.lag_one,
        best.kurtosis,
        best.skewness,
        base.skewness,
        max(a.coloured_n / max(a.white_n, 1e-12) for a, _ in noise),
        max(float(np.hypot(a.white_n, a.coloured_n) / max(np.hypot(b.white_n, b.coloured_n), 1e-12)) for a, b in noise),
        propagates,
        strain(found.noise, found.measured),
        sticking.rests(sim.problem.records, sim.predict_fine(found.base.theta, {})),
        # beside an accepted model all that is slow belongs to its known scatter
        0.0 if sim.problem.scatters else sum(found.noise.wanders.values()),
        _grown(found),
    )
    return Rows(log, (*candidates, *beside), base, best, nameless.words(found), scatters=sim.problem.scatters)


def _grown(found: Search) -> float:
    """Return which share of the squared error beyond the noise an accepted model, as it was or re-tuned, did not leave before; 0 of others."""
    sim, f = found.sim, found.base
    if sim.accepted is None:
        return 0.0
    noise = floor_n(sim.problem.records, sim.phases(f.theta, f.effects, found.noise), found.noise)
    beyond = min(_power(sim, sim.y - sim.predict(sim.accepted, {})), _power(sim, f.residual)) - noise**2
    return float(max(1.0 - rms_n(sim.problem) ** 2 / beyond, 0.0)) if beyond > 0.0 else 0.0


def _independent(found: Search, samples: int) -> int:
    """Return how many independent samples there are: a known scatter that is slow says the same for as long as it lasts."""
    count = alone = 0.0
    for r in found.sim.problem.records:
        kept = float(np.sum(r.weight > 0))
        share = 0.0
        if r.misfit_n is not None:
            scatter = float(np.mean(r.misfit_n**2))
            share = scatter / max(scatter + found.noise.output[r.system].white_n ** 2 / r.factor, 1e-300)
        count += kept
        lasting = np.broadcast_to(2.0 * r.misfit_s / (r.dt_s * r.factor) - 1.0, len(r.weight))
        alone += float(np.sum((r.weight > 0) / (1.0 + share * np.maximum(lasting, 0.0))))
    return max(1, round(samples * alone / max(count, 1.0)))


def _examined(ranked: Sequence[Weighed]) -> list[Weighed]:
    """Return the leading models of each size and their parts, and the best ones that do without a leading effect."""
    chosen = [w for size in sorted({len(w.ids) for w in ranked}) for w in [x for x in ranked if len(x.ids) == size][:EXAMINED]]
    # what a part leaves says whether the rest is needed: crowded out by its own combinations it would seem to explain nothing
    parts = {i for w in ranked[:EXAMINED] for i in w.ids}
    chosen += [w for w in ranked if len(w.ids) == 1 and w.ids[0] in parts and all(w is not c for c in chosen)]
    for leader in {i for w in ranked[:2] for i in w.ids}:
        without = [w for w in ranked if leader not in w.ids]
        chosen += [w for w in without[:1] if all(w is not c for c in chosen)]
    return chosen


def _held(found: Search, examined: Sequence[Weighed], reducible: float) -> dict[tuple[str, ...], float]:
    """Return the largest share of what is reducible that models may remove of what is held out; nothing where nothing new is.

    A ratio over blocks of a few seconds, and as many of its standard errors as so few blocks need: where the gap is small beside the
    noise, squares say little.
    """
    sim, held = found.sim, found.held_out
    if not held.folds.honest:
        return {}
    if sim.problem.scatters:
        # beside what an accepted rig is known to scatter by an error says little: the share of its gain that a model keeps
        nats = held.nats(found.base)
        return {w.ids: (nats - held.nats(w.fit)) / max(w.gain, 1.0) for w in examined}
    left = held.residual(found.base)
    block = blocks(sim)
    floor = max(_power(sim, found.base.residual) - reducible, 0.0)
    base = np.bincount(block, sim.weight * left**2)
    gap = base - floor * np.bincount(block, sim.weight)
    foretell = [w.fit for w in examined if w.fit.hypothesis.foretold]
    errors = {f.ids: np.bincount(block, sim.weight * held.residual(f) ** 2) for f in foretell}
    return {ids: _at_most(np.asarray(base - left, np.float64), gap) for ids, left in errors.items()}


def _at_most(removed: Array, gap: Array) -> float:
    """Return the upper 97.5 % limit of the ratio of two sums over blocks, infinite where the lower sum is not above 0 or of one block."""
    total = float(gap.sum())
    if total <= 0.0 or len(gap) < 2:
        return float("inf")
    share = float(removed.sum()) / total
    scatter = float(np.sum((removed - share * gap) ** 2)) * len(gap) / (len(gap) - 1)
    return share + float(stdtrit(len(gap) - 1, 0.975)) * float(np.sqrt(scatter)) / total


def _means(x: Leftover) -> float:
    """Return the largest statistic of the tests of means: what is systematic, not only loud."""
    return max(t.z for t in x.tests if t.name.startswith("mean"))


def _power(sim: Simulator, residual: Array) -> float:
    return float(np.sum(sim.weight * residual**2) / max(float(sim.weight.sum()), 1.0))


def _reducible(found: Search) -> float:
    """Return what the base leaves beyond the noise (squared, N^2)."""
    f = found.base
    floor = floor_n(found.sim.problem.records, found.sim.phases(f.theta, f.effects, found.noise), found.noise, scatter=True)
    return _power(found.sim, f.residual) - floor**2


def _candidate(found: Search, w: Weighed, left: Leftover, reducible: float) -> CandidateRow:
    return CandidateRow(
        tuple(sorted(w.ids)),
        OUTPUT,
        len(w.fit.hypothesis.strengths),
        w.gain,
        w.evidence,
        w.evidence - max((p.evidence for p in found.parts(w.ids)), default=0.0),
        left.chi2,
        left.worst().z,
        _means(left),
        sum(w.fit.at_bound(i) for i, f in enumerate(w.fit.free) if not f.parameter.shape),
        instability(found.sim, w.fit),
        _share(_power(found.sim, found.base.residual) - _power(found.sim, w.fit.residual), reducible),
    )


def _share(removed: float, reducible: float) -> float:
    """Return the part of the reducible squared error that is removed, 1 where nothing is reducible beyond it."""
    return float(np.clip(removed / reducible, 0.0, 1.0)) if reducible > max(removed, 0.0) else float(removed > 0.0)


def instability(sim: Simulator, f: Fit) -> float:
    """Return the squared difference of the strengths between two halves of the runs, over what noise allows, a strength."""
    place = [i for i, x in enumerate(f.free) if not x.parameter.shape]
    if len(sim.problem.records) < 2 or not place:
        return 1.0
    j, r = f.whiten(f.jacobian), f.whiten.left(f.residual)
    configs, parts = len(f.theta), []
    # names decide nothing
    place_of = np.argsort(sorted(range(len(sim.problem.records)), key=lambda i: content(sim.problem.records[i])))
    half_of = place_of % 4 // 2 if len(place_of) >= 4 else place_of % 2
    for half in (0, 1):
        rows = half_of[sim.run] == half
        a, b = normal_equations(sim, j * rows[:, None], r)
        known = inverse(a, 1e-9)
        parts.append((known @ b, known))
    at = configs + np.array(place)
    difference = parts[0][0][at] - parts[1][0][at]
    covariance = parts[0][1][np.ix_(at, at)] + parts[1][1][np.ix_(at, at)]
    return float(difference @ np.linalg.pinv(covariance) @ difference) / len(place)

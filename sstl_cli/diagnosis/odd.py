"""Leave one run out: the rows that a finished search would have had without it, to first order.

The cost of a fit is a sum over runs, and so are its normal equations: without a run they are those of all less its own, and
the fit moves by one Gauss-Newton step (Pregibon 1981). Phases and noise stay. Whether the verdict really differs is told by a
diagnosis without the run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import HALF, THETA_HIGH, THETA_LOW
from sstl_cli.diagnosis.evidence import Weighed, strengths_charge
from sstl_cli.diagnosis.features import OUTPUT, CandidateRow, Ids, Rows, leading
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.verdict import AMBIGUOUS, UNDECIDED, Verdict
from sstl_cli.diagnosis.whitening import Whitener

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Suspect:
    """A run without which the verdict is likely to differ, and how much probability its absence moves."""

    run_id: str
    moved: float


@dataclass(frozen=True)
class _Left:
    """What one model leaves without each run, shape (runs,): cost (nats) and squared whitened residual; and of all runs."""

    cost: Array
    squared: Array
    all_squared: float


def suspects(said: Verdict, whole: Rows, run_ids: Sequence[str], rows: Sequence[Rows], decide: Callable[[Rows], Verdict]) -> list[Suspect]:
    """Return the runs without which the verdict differs by their rows, those that move the most probability first.

    Of those that move as much the one comes first without which there is least to explain.

    Of an unknown cause also those that hold most of what is left: to first order the noise stays as large as they made it.

    Parameters
    ----------
    said : Verdict
        Of all runs, by the rows ``whole``.
    rows : sequence of Rows
        Without each of ``run_ids``.
    """
    odd = []
    for run_id, less in zip(run_ids, rows, strict=True):
        then = decide(less)
        held = 1.0 - _worst(less, whole) / max(_worst(whole, whole), 1e-9) if said.status == UNDECIDED else 0.0
        if differs(said, then) or held > HALF:
            odd.append((Suspect(run_id, max(_moved(said, then), held)), less.log.base_chi2))
    return [s for s, _ in sorted(odd, key=lambda s: (-s[0].moved, s[1], s[0].run_id))]


def _worst(rows: Rows, whole: Rows) -> float:
    """Return the worst test of what the leading model of all runs leaves, or the base where none leads."""
    lead = leading(whole)
    return next((c.worst_z for c in rows.candidates if lead is not None and c.ids == lead.ids), rows.log.base_worst_z)


def differs(a: Verdict, b: Verdict) -> bool:
    """Whether two verdicts say different things; which of two that explain alike comes first is no difference.

    Examples
    --------
    >>> first = Verdict("ambiguous", ("a",), None, (("a",), ("b",)), {}, "")
    >>> differs(first, Verdict("ambiguous", ("b",), None, (("b",), ("a",)), {}, ""))
    False
    >>> differs(first, Verdict("identified", ("a",), None, (("a",),), {}, ""))
    True
    """
    if a.status != b.status or a.status != AMBIGUOUS:
        return (a.status, set(a.effects)) != (b.status, set(b.effects))
    return a.effects not in b.group or b.effects not in a.group


def _moved(a: Verdict, b: Verdict) -> float:
    """Return the distance of two verdicts' probabilities (total variation, 0 to 1)."""
    keys = {*a.probabilities, *b.probabilities}
    return 0.5 * sum(abs(a.probabilities.get(k, 0.0) - b.probabilities.get(k, 0.0)) for k in keys)


def rows_without(found: Search, rows: Rows, beside: Callable[[int], Sequence[CandidateRow]]) -> list[Rows]:
    """Return the rows without each run, to first order.

    Parameters
    ----------
    rows : Rows
        Of all runs.
    beside : callable
        Candidates of the recorder and of other channels without the run at a place.
    """
    sim = found.sim
    count = np.bincount(sim.run, found.base.whiten.scale > 0.0, len(sim.problem.records))
    total = max(float(count.sum()), 1.0)
    base = _left(found, found.base)
    models = {tuple(sorted(w.ids)): (w, _left(found, w.fit)) for w in found.every()}
    fitted = [c for c in rows.candidates if c.kind == OUTPUT]
    out = []
    for i in range(len(count)):
        kept = max(total - float(count[i]), 1.0)
        gains = {k: float(base.cost[i] - left.cost[i]) for k, (_, left) in models.items()}
        evidence = {k: w.evidence + _worth(found, w, gains) for k, (w, _) in models.items()}
        candidates = [_row(c, models[c.ids][1], i, kept, total, gains, evidence) for c in fitted]
        calmer = _calmer(base, i, kept, total)
        log = replace(
            rows.log, samples=max(round(rows.log.samples * kept / total), 1), base_chi2=float(base.squared[i]) / kept,
            base_worst_z=rows.log.base_worst_z * calmer, base_mean_z=rows.log.base_mean_z * calmer,
        )  # fmt: skip
        out.append(replace(rows, log=log, candidates=(*candidates, *beside(i))))
    return out


def _row(
    c: CandidateRow, left: _Left, i: int, kept: float, total: float, gains: Mapping[Ids, float], evidence: Mapping[Ids, float]
) -> CandidateRow:
    lacking = [p for p in evidence if len(p) == len(c.ids) - 1 and set(p) < set(c.ids)]
    calmer = _calmer(left, i, kept, total)
    return replace(
        c, gain=gains[c.ids], evidence=evidence[c.ids], drop_one=evidence[c.ids] - max((evidence[p] for p in lacking), default=0.0),
        chi2=float(left.squared[i]) / kept, worst_z=c.worst_z * calmer, mean_z=c.mean_z * calmer,
    )  # fmt: skip


def _calmer(left: _Left, i: int, kept: float, total: float) -> float:
    """Return by what factor tests of what is left fall without a run: as its excess over chance does, where it has one."""
    excess = left.all_squared - total
    return float(np.clip((left.squared[i] - kept) / excess, 0.0, 1.0)) if excess > 0.0 else 1.0


def _worth(found: Search, w: Weighed, gains: Mapping[Ids, float]) -> float:
    """Return what a model's evidence changes by: its gain, less what a smaller response costs less."""
    ids = tuple(sorted(w.ids))
    change = gains[ids] - w.gain
    for effect_id in ids:
        k = sum(x.effect.id == effect_id for x in w.fit.hypothesis.strengths)
        rest = tuple(x for x in ids if x != effect_id)
        there = rest in gains
        before, now = (w.gain - found.best(rest).gain, gains[ids] - gains[rest]) if there else (w.gain, gains[ids])
        change += strengths_charge(k, 2.0 * before) - strengths_charge(k, 2.0 * now)
    return float(change)


def _left(found: Search, f: Fit) -> _Left:
    """Return what a fit leaves without each run, one bounded Gauss-Newton step further."""
    sim = found.sim
    columns = f.whiten.beside(f.residual, f.jacobian)
    configs = len(f.theta)
    low = np.concatenate((np.full(configs, THETA_LOW), [x.parameter.least for x in f.free])) - np.concatenate((f.theta, f.values))
    high = np.concatenate((np.full(configs, THETA_HIGH), [x.parameter.most for x in f.free])) - np.concatenate((f.theta, f.values))
    runs, size = sim.problem.records, configs + len(f.free)
    a, b = np.zeros((len(runs), size, size)), np.zeros((len(runs), size))
    squared = np.zeros(len(runs))
    for i, (r, s) in enumerate(zip(runs, sim.slices(), strict=True)):
        gram = columns[s].T @ columns[s]
        at = np.concatenate(([r.config], np.arange(configs, size)))
        a[i][np.ix_(at, at)], b[i][at], squared[i] = gram[1:, 1:], gram[1:, 0], gram[0, 0]
    others, pull = a.sum(axis=0) - a, b.sum(axis=0) - b
    ridge = np.array([1e-6 * np.diag(np.diag(x) + 1e-9) for x in others])
    step = np.clip(np.linalg.solve(others + ridge, pull[:, :, None])[:, :, 0], low, high)
    fall = 2.0 * np.sum(pull * step, axis=1) - np.einsum("ri,rij,rj->r", step, others, step)
    remains = squared.sum() - squared - np.maximum(fall, 0.0)
    return _Left(0.5 * (remains + f.whiten.log_det - _log_dets(f.whiten, sim.slices())), remains, float(squared.sum()))


def _log_dets(whiten: Whitener, runs: Sequence[slice]) -> Array:
    """Return by how much the log-determinant of the covariance falls without each run, with what is known to vary."""
    found = np.array([-2.0 * float(np.sum(np.log(whiten.scale[s][whiten.scale[s] > 0.0]))) for s in runs])
    if whiten.beyond is not None:
        found += [float(whiten.beyond[s].sum()) for s in runs]
    every = np.arange(len(whiten.scale))
    for turn in whiten.known:
        for block, axes, less in zip(turn.blocks, turn.axes, turn.less, strict=True):
            rows = every[block]
            grown = 1.0 / (1.0 - less) ** 2
            directions = axes * np.sqrt(grown - 1.0)
            for i, s in enumerate(runs):
                own = directions[(rows >= s.start) & (rows < s.stop)]
                if len(own):
                    found[i] += float(np.sum(np.log(grown))) - float(np.linalg.slogdet(np.diag(grown) - own.T @ own)[1])
    return found

"""Candidates side by side: which of the fitted ones are listed, and each one's numbers against the base and the likeliest."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from sstl_cli.diagnosis import limit, scaling, shrink
from sstl_cli.diagnosis.channels import ChannelGap
from sstl_cli.diagnosis.constants import DECIDES_NATS, RIVALS
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.gap import Errors
from sstl_cli.diagnosis.judged import Judged


@dataclass(frozen=True)
class Compared:
    """A fitted candidate: how probable, its held-out error (N, RMS) and by how much that falls, and how well the data hold its parameters.

    ``d2`` is its squared distance from the likeliest, None where that is not worked out; ``change`` by how much parameters of effects
    that the simulator contains differ from what it says; ``intervals`` (95 %) and ``labels`` are of its parameters in order, ``best``
    the best label of a strength; ``alternatives`` are the strengths of other hypotheses of the same effect that explain the data as well.
    """

    model: Weighed
    probability: float
    rmse_n: float
    fall_pct: float
    d2: float | None
    change: dict[str, float] | None
    intervals: tuple[tuple[float, float] | None, ...]
    labels: tuple[str, ...]
    best: str
    alternatives: tuple[dict[str, float], ...]


def compared(g: Judged, errors: Errors) -> list[Compared]:
    """Return single effects, the most probable and the most evident combinations, and what is named."""
    ranked = g.search.ranked()
    near = sorted(ranked, key=lambda w: -_probability(g, w))[: RIVALS + 1]
    named = (g.verdict.effects, *g.verdict.group)
    # what has the evidence and is not believed is shown as well: whoever reads the table may know better
    shown = [w for w in ranked if len(w.ids) == 1 or w in near or w in ranked[:RIVALS] or w.ids in named or tuple(sorted(w.ids)) in named]
    lead = next((w for w in ranked if w.fit is g.accepted), ranked[0] if ranked else None)
    return [_one(g, errors, w, lead if w in near else None) for w in shown]


def _probability(g: Judged, w: Weighed) -> float:
    return g.verdict.probabilities.get(tuple(sorted(w.ids)), 0.0)


def _one(g: Judged, errors: Errors, w: Weighed, lead: Weighed | None) -> Compared:
    sim, f = g.search.sim, w.fit
    held = errors.accepted if f is g.accepted else errors.known + g.search.held_out.residual(f)
    intervals = shrink.parameter_intervals(sim, f)
    labels = [shrink.identifiability(f, i, x) for i, x in enumerate(intervals)]
    strengths = [s for s, x in zip(labels, f.free, strict=True) if not x.parameter.shape]
    base = errors.rms(errors.base)
    return Compared(
        model=w,
        probability=_probability(g, w),
        rmse_n=errors.rms(held),
        fall_pct=100.0 * (1.0 - errors.rms(held) / base) if base > 0.0 else 0.0,
        d2=None if lead is None or lead is w else limit.distance2(sim, lead.fit, f),
        change=_change(g, f),
        # a strength that cannot be negative is not there at the least
        intervals=tuple(
            None if ci is None else (max(ci.low, x.parameter.least), min(ci.high, x.parameter.most))
            for x, ci in zip(f.free, intervals, strict=True)
        ),
        labels=tuple(labels),
        best=next((s for s in ("identifiable", "weak") if s in strengths), "not_identifiable"),
        alternatives=tuple(_strengths(other.fit, g.problem.unit_n) for other in as_evident(g.search, w)),
    )


def as_evident(found: Search, w: Weighed) -> list[Weighed]:
    """Return the other hypotheses of an effect (which sensor, which law) that the data do not put behind a model of it.

    None that has more strengths, or those of the model and others.
    """
    own = _names(w.fit)
    others = [(o, _names(o.fit)) for o in found.singles.get(w.ids[0], ()) if len(w.ids) == 1 and o.evidence > w.evidence - DECIDES_NATS]
    return [o for o, names in others if names != own and len(names) <= len(own)]


def _names(f: Fit) -> set[str]:
    return {x.parameter.name for x in f.hypothesis.strengths}


def _strengths(f: Fit, unit_n: float) -> dict[str, float]:
    """Return the strengths of a fit by name, in the units of the recording."""
    values = zip(f.free, f.values, strict=True)
    strengths = f.hypothesis.strengths
    return {x.parameter.name: scaling.parameter(float(v), x.parameter.unit, unit_n) for x, v in values if x in strengths}


def _change(g: Judged, f: Fit) -> dict[str, float] | None:
    """Return by how much the parameters of effects that the simulator contains differ from what it says, if any do."""
    there = g.search.sim.fixed
    moved = {
        x.parameter.name: scaling.parameter(float(v) - x.parameter.neutral, x.parameter.unit, g.problem.unit_n)
        for x, v in zip(f.free, f.values, strict=True)
        if x.effect.id in there and not x.parameter.shape
    }
    return moved or None


def only_beside(gaps: Sequence[ChannelGap], others: Collection[str]) -> list[ChannelGap]:
    """Return what the channels beside the output show and none of the ``others`` (ids) does, the first of each effect."""
    found: dict[str, ChannelGap] = {}
    for gap in gaps:
        found.setdefault(gap.effect, gap)
    return [gap for effect, gap in found.items() if effect not in others]

"""The verdict: one pure function from what was found to what is said.

A nested multinomial model (McFadden 1978): the log's numbers give the probabilities that nothing is missing, that something
without a name is, and that a candidate is; among the candidates each has the exponential of a weighted sum of its numbers
over the sum of all. The logarithm of that sum, the inclusive value, is one of the log's numbers: how well the candidates do as causes. Weights and thresholds are learned (see :mod:`sstl_cli.diagnosis.weights`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp, softmax

from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN, barred, causes, grown, sizeable, wandering
from sstl_cli.diagnosis.constants import DECIDES_NATS, DOUBT_NATS, HALF, JOINS_NATS, LEAST_SHARE, MISFITS, UNNAMED
from sstl_cli.diagnosis.evidence import discounted
from sstl_cli.diagnosis.features import BESIDE, OUTPUT, RECORDER, CandidateRow, Ids, Rows, best_of, leading
from sstl_cli.diagnosis.hypotheses import FAMILIES, title, with_zeros
from sstl_cli.diagnosis.reasons import carried, explained, left, nearer, partly, strained
from sstl_cli.diagnosis.weights import Weights

Array = NDArray[np.float64]
IDENTIFIED, AMBIGUOUS, UNDECIDED, NOTHING = "identified", "ambiguous", "unknown", "none"
REACH_NATS = 60.0

CANDIDATE_TERMS = (
    "behind", *(f"log_behind_{m:g}" for m in MISFITS), "rank", "ahead", "left_share", "little", "means", "more", "weak_part", "outside", "unstable",
    "strengths", "recorder", "recorder_share", "recorder_gain", "recorder_out", "beside", "beside_gain", "beside_share", "beside_out",
)  # fmt: skip
LOG_TERMS = (
    "one", "nats", "best", "base_rms", "base_worst", "base_means", "left_share", "left_rms", "worst", "means", "little",
    "outside", "recorder", "beside", "beside_left", "beside_base", "coloured", "noise_ratio", "inclusive",
)  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """What is said: status, effects (the most probable model's), how sure, and the set that holds the truth."""

    status: str
    effects: Ids
    confidence: float | None
    group: tuple[Ids, ...]
    probabilities: Mapping[Ids, float]
    why: str

    @property
    def classes(self) -> dict[str, tuple[str, ...]]:
        """Families of which several members are in the set, by a name that lists them."""
        inside = {ids[0] for ids in self.group if len(ids) == 1}
        found = {family: tuple(m for m in members if m in inside) for family, members in FAMILIES.items()}
        return {f"{family}: {' | '.join(parts)}": parts for family, parts in found.items() if len(parts) > 1}


def _squash(x: float) -> float:
    """Return a number on a scale on which ten and a hundred are two steps apart, with its sign."""
    return float(np.sign(x) * np.log10(1.0 + abs(x)))


def standing(rows: Rows) -> Rows:
    """Return the rows without combinations of which a part adds no evidence of its own: weak effects like to join."""
    kept = tuple(c for c in rows.candidates if len(c.ids) == 1 or c.drop_one > JOINS_NATS)
    return replace(rows, candidates=kept)


def candidate_terms(c: CandidateRow, rows: Rows) -> Array:
    """Return the numbers of one candidate, in the order of ``CANDIDATE_TERMS``."""
    log, top = rows.log, max(best_of(rows), 0.0)
    alike = [o for o in rows.candidates if o.kind == c.kind and len(o.ids) == len(c.ids)]
    above = sum(o.evidence > c.evidence for o in alike)
    ahead = c.evidence - max((o.evidence for o in alike if o.ids != c.ids), default=0.0)
    out = c.kind == OUTPUT
    # a fault of the recorder, or a lag beside, leaves of the output what the base leaves of its sound samples
    chi2, means = (c.chi2, c.mean_z) if out else (log.base_chi2, log.base_mean_z)
    left = max(chi2 - 1.0, 0.0) * log.samples / 2.0
    values = {
        "behind": float(np.clip(c.evidence - top, -REACH_NATS, 0.0)) / 10.0 if out else 0.0,
        "rank": float(np.log2(1.0 + above)) if out else 0.0,
        "ahead": _squash(max(ahead, 0.0)) if out else 0.0,
        "left_share": left / (left + max(c.gain, 1.0)),
        "little": 1.0 - nearer(c, rows) if out else 0.0,
        "means": _squash(max(means, 0.0)),
        "more": float(len(c.ids) - 1),
        "weak_part": _squash(1e3 * np.clip(c.drop_one / max(c.evidence, 1e-9), 0.0, 1.0)) if len(c.ids) > 1 else 0.0,
        "outside": float(c.outside > 0),
        "unstable": _squash(max(c.unstable - 1.0, 0.0)) if out else 0.0,
        "strengths": float(c.strengths),
        "recorder": float(c.kind == RECORDER),
        "recorder_share": _squash(10.0 * c.share) if c.kind == RECORDER else 0.0,
        "recorder_gain": _squash(max(c.gain, 0.0)) if c.kind == RECORDER else 0.0,
        # what the output asks for is left wherever a cause is named that the output does not show
        "recorder_out": _squash(top) if c.kind == RECORDER else 0.0,
        "beside_out": _squash(top) if c.kind == BESIDE else 0.0,
        "beside": float(c.kind == BESIDE),
        "beside_gain": _squash(max(c.evidence, 0.0)) if c.kind == BESIDE else 0.0,
        "beside_share": c.share if c.kind == BESIDE else 0.0,
    }
    apart = _apart(c, rows)
    for m in MISFITS:
        behind = discounted(c.evidence - top, m, apart) if out else 0.0
        values[f"log_behind_{m:g}"] = _squash(min(behind, 0.0))
    return np.array([values[t] for t in CANDIDATE_TERMS])


def _apart(c: CandidateRow, rows: Rows) -> float:
    """Return the evidence (nats) of what tells a candidate from the most evident model."""
    lead = leading(rows)
    return 0.0 if lead is None else _own(lead, c.ids, rows)


def _own(c: CandidateRow, other: Ids, rows: Rows) -> float:
    """Return the evidence (nats) of a candidate without that of the effects that another one has as well."""
    both = set(c.ids) & set(other)
    shared = max((o.evidence for o in rows.candidates if o.kind == OUTPUT and set(o.ids) <= both), default=0.0)
    return max(c.evidence - max(shared, 0.0), 0.0)


def inclusive(of_candidates: Sequence[float] | Array) -> float:
    """Return the inclusive value of the candidates' weighted sums, 0 where there is none."""
    return float(logsumexp(of_candidates)) if len(of_candidates) else 0.0


def log_terms(rows: Rows, inclusive_value: float = 0.0) -> Array:
    """Return the numbers of the log, in the order of ``LOG_TERMS``: is anything there, and does the leading model explain it."""
    log, lead = rows.log, leading(rows)
    best = gain = 0.0
    chi2, worst, means, share = log.base_chi2, log.base_worst_z, log.base_mean_z, 1.0
    if lead is not None:
        best, gain, chi2, worst, means, share = lead.evidence, lead.gain, lead.chi2, lead.worst_z, lead.mean_z, lead.share
    recorder = max((c for c in rows.candidates if c.kind == RECORDER), key=lambda c: c.share, default=None)
    beside = max((c for c in rows.candidates if c.kind == BESIDE), key=lambda c: c.evidence, default=None)
    left = max(chi2 - 1.0, 0.0) * log.samples / 2.0
    values = {
        "one": 1.0,
        # evidence is a logarithm of odds over the base; what is beyond doubt is no surer with more of it
        "nats": float(np.clip(best, 0.0, DOUBT_NATS)) / 2.5,
        "best": _squash(best),
        "base_rms": _squash(10.0 * np.sqrt(max(log.base_chi2 - 1.0, 0.0))),
        "base_worst": _squash(max(log.base_worst_z, 0.0)),
        "base_means": _squash(max(log.base_mean_z, 0.0)),
        "left_share": left / (left + max(gain, 1.0)),
        "left_rms": _squash(10.0 * np.sqrt(max(chi2 - 1.0, 0.0))),
        "worst": _squash(max(worst, 0.0)),
        "means": _squash(max(means, 0.0)),
        "little": 1.0 - share,
        "outside": float(lead is not None and lead.outside > 0),
        "recorder": 0.0 if recorder is None else recorder.share * _squash(max(recorder.gain, 0.0)),
        "beside": 0.0 if beside is None else float(np.clip(beside.evidence, 0.0, DOUBT_NATS)) / 2.5,
        # what a law leaves of the channel beside counts as far as the law is needed there at all
        "beside_left": 0.0 if beside is None else max(beside.share, 0.0) * _squash(max(beside.chi2 - 1.0, 0.0)),
        # what the simulator leaves of a channel beside is there, whoever explains it
        "beside_base": 0.0 if beside is None else _squash(max(beside.chi2 / max(1.0 - beside.share, np.finfo(float).eps) ** 2 - 1.0, 0.0)),
        "coloured": min(log.coloured, 3.0),
        "noise_ratio": _squash(10.0 * abs(np.log(max(log.noise_ratio, 1e-9)))),
        "inclusive": inclusive_value,
    }
    return np.array([values[t] for t in LOG_TERMS])


def probabilities(rows: Rows, w: Weights, prior: Mapping[str, float] | None = None) -> dict[Ids, float]:
    """Return the probability of every candidate, of ``none`` and of ``unknown``; they sum to 1.

    Parameters
    ----------
    prior : mapping of effect id to float, optional
        The user's own odds of effects over those of the library (1: as there).
    """
    rows = standing(rows)
    own = np.array([w.candidate[t] for t in CANDIDATE_TERMS])
    odds = {c.ids: sum(float(np.log((prior or {}).get(i, 1.0))) for i in c.ids) for c in rows.candidates}
    plain = {
        c.ids: float(own @ candidate_terms(c, rows)) + sum(w.effect.get(i, UNNAMED if i in rows.barred else 0.0) for i in c.ids)
        for c in rows.candidates
    }
    named = {k: v + odds[k] for k, v in plain.items()}
    log = log_terms(rows, inclusive(list(plain.values())))
    # odds against what is seen speak for what has no name, and for nothing
    all_named = float(logsumexp(list(named.values())) - logsumexp(list(plain.values()))) if named else -np.inf
    is_named, is_none, is_unknown = (
        float(p) for p in softmax([all_named, *(float(np.array([x[t] for t in LOG_TERMS]) @ log) for x in (w.none, w.unknown))])
    )
    within = [float(p) for p in softmax(list(named.values()))] if named else []
    return {**{k: is_named * p for k, p in zip(named, within, strict=True)}, NONE: is_none, UNKNOWN: is_unknown}


def verdict(rows: Rows, weights: Weights, prior: Mapping[str, float] | None = None) -> Verdict:
    """Return what is to be said of a log.

    Parameters
    ----------
    rows : Rows
        All evidence, of the output, the recorder and the channels beside.
    prior : mapping of effect id to float, optional
        The user's own odds of effects; then no confidence can be given.
    """
    said = _with_faults(decided(rows, probabilities(rows, weights, prior), weights, prior), rows, weights, prior)
    return replace(said, probabilities=tempered(said.probabilities, weights.temper))


def tempered(p: Mapping[Ids, float], power: float) -> dict[Ids, float]:
    """Return probabilities whose odds between a cause with a name, none and one without are raised to a power; they sum to 1.

    Which of the causes it is, where one has a name, the model says as surely as it may (Guo, Pleiss, Sun, Weinberger 2017).
    """
    named = sum(v for k, v in p.items() if k not in (NONE, UNKNOWN))
    odds = np.array([named, p.get(NONE, 0.0), p.get(UNKNOWN, 0.0)]) ** power
    of_named, none, unknown = (float(x) for x in odds / odds.sum())
    share = of_named / named if named > 0.0 else 0.0
    return {**{k: v * share for k, v in p.items() if k not in (NONE, UNKNOWN)}, NONE: none, UNKNOWN: unknown}


def _with_faults(said: Verdict, rows: Rows, weights: Weights, prior: Mapping[str, float] | None) -> Verdict:
    """Return the verdict with both causes where the recorder has a fault and the rig an effect: neither is a reason against the other.

    What the recorder has spoilt is left out of what candidates of the output are judged by: they are asked alone. Where they are a set,
    the fault stands beside each of them.
    """
    faults = [c for c in rows.named.candidates if c.kind == RECORDER and c.evidence > DOUBT_NATS and c.share > LEAST_SHARE]
    if said.status not in (IDENTIFIED, AMBIGUOUS) or not faults:
        return said
    rest = replace(rows, candidates=tuple(c for c in rows.candidates if c.kind != RECORDER))
    p = probabilities(rest, weights, prior)
    of_rig, outputs = decided(rest, p, weights, prior), {c.ids for c in rest.candidates if c.kind == OUTPUT}
    asked = (of_rig.effects,) if said.status == IDENTIFIED else (*said.group, *of_rig.group)
    if of_rig.status != said.status or not outputs.issuperset(asked):
        return said
    own = [i for c in faults for i in c.ids]
    group = tuple(tuple(sorted((*ids, *own))) for ids in of_rig.group)
    why = "; ".join((of_rig.why, *(f"beside it {explained(rows, c.ids)}" for c in faults)))
    sure = None
    if said.confidence is not None and of_rig.confidence is not None:
        # both names have to be right, and whether they err together nobody knows; both sets are of the rig, the fault is beyond doubt
        sure = said.confidence * of_rig.confidence if said.status == IDENTIFIED else min(said.confidence, of_rig.confidence)
    return Verdict(said.status, tuple(sorted((*of_rig.effects, *own))), sure, group, said.probabilities, why)


def decided(rows: Rows, p: Mapping[Ids, float], weights: Weights, prior: Mapping[str, float] | None = None) -> Verdict:
    """Return what is to be said of a log at given probabilities, by the thresholds alone of the weights."""
    if rows.log.propagates < 1.0:
        why = "the output never leaves its hold: without propagation no effect can show; use a larger stroke"
        return Verdict(UNDECIDED, (), None, (), p, why)
    p = causes(rows, sizeable(rows, p))
    p, unlisted = barred(rows, p)
    p, slow = wandering(rows, p)
    unnamed, changed = unlisted or slow, grown(rows)

    def say(status: str, effects: Ids, stated: float, group: tuple[Ids, ...], why: str) -> Verdict:
        return Verdict(status, effects, None if prior else weights.right(status, stated), group, p, why)

    ranked = sorted((k for k in p if k not in (NONE, UNKNOWN)), key=lambda k: (-p[k], k))
    named = sum(p[k] for k in ranked)
    top = ranked[0] if ranked else NONE
    first = next((c for c in rows.candidates if c.ids == top), None)
    takes = 1.0 if first is None else carried(first, rows)
    family = _family(top, p)
    # that it is one of a family the odds say; which of them it is, the evidence
    sure = sum(p[k] for k in family) if ranked else 0.0
    if first is not None and (takes <= LEAST_SHARE or strained(first)) and p[NONE] < max(p[UNKNOWN], named):
        idle = sure + sum(p[c.ids] for c in rows.candidates if c.ids in p and c.ids not in family and carried(c, rows) <= LEAST_SHARE)
        none, unknown = _released(p, idle, strained(first))
        if none > max(unknown, named - idle):
            if changed:
                return say(UNDECIDED, (), none + unknown, (), changed)
            return say(NOTHING, (), none, (), f"{partly(rows, top)}, and what is left looks like noise")
        return say(UNDECIDED, (), unknown, (), unnamed or left(rows, top))
    tied = _tied(standing(rows), top)
    # whoever leads, a set holds who is as evident, and who is probable
    rivalling = dict.fromkeys((*tied, *_nearer(_set(ranked, p, weights.cover), rows)))
    # of what most of the gap comes from in spite of it nobody is sure
    commits = sure >= weights.commit and takes >= HALF
    if commits and not _told(rows, top, family, weights.member):
        group = tuple(dict.fromkeys((*family, *rivalling)))
        why = f"{explained(rows, top)}; which of {', '.join(' + '.join(k) for k in group)} it is, this data does not tell"
        return say(AMBIGUOUS, top, sum(p[k] for k in group), group, why)
    if commits and tied:
        group = tuple(dict.fromkeys((top, *sorted(rivalling, key=lambda k: (-p[k], k)))))
        rivals = ", ".join(" + ".join(k) for k in group[1:])
        said = f"{explained(rows, top)}; {rivals} explain{'' if len(group) > 2 else 's'} this data as well"
        return say(AMBIGUOUS, top, sum(p[k] for k in group), group, said)
    if commits:
        return say(IDENTIFIED, top, sure, (top,), explained(rows, top))
    # members of a family that share their probability are one cause
    likely = max(p[UNKNOWN], sure)
    if p[NONE] >= likely and p[NONE] >= min(weights.quiet, named):
        if changed:
            return say(UNDECIDED, (), p[NONE] + p[UNKNOWN], (), changed)
        why = "no candidate improves the error by more than noise can, and what is left looks like noise"
        if p[NONE] < named:
            why = f"nothing is likelier than any one effect, though not than all of them together, of which {' + '.join(top)} is the most likely"
        return say(NOTHING, (), p[NONE], (), why)
    if p[UNKNOWN] >= named:
        return say(UNDECIDED, (), p[UNKNOWN], (), unnamed or left(rows, top))
    group = _nearer(_set(ranked, p, weights.cover), rows)
    why = explained(rows, top) if takes >= HALF else partly(rows, top)
    rivals = ", ".join(" + ".join(k) for k in group[1:])
    why += f"; not ruled out: {rivals}" if rivals else f", but {_runner_up(p)} is not ruled out"
    return say(AMBIGUOUS, top, sum(p[k] for k in group), group, why)


def _released(p: Mapping[Ids, float], share: float, describes: bool) -> tuple[float, float]:
    """Return the probabilities of nothing and of what has no name, with the share of what is no cause: as likely as they are, or all to the latter."""
    nothing = 0.0 if describes else share * p[NONE] / max(p[NONE] + p[UNKNOWN], np.finfo(float).tiny)
    return p[NONE] + nothing, p[UNKNOWN] + share - nothing


def _family(top: Ids, p: Mapping[Ids, float]) -> tuple[Ids, ...]:
    """Return the candidates with the same effects but for members of the same families, the most probable first."""
    own = sorted(title(i) for i in top)
    return tuple(sorted((k for k in p if k not in (NONE, UNKNOWN) and sorted(title(i) for i in k) == own), key=lambda k: (-p[k], k)))


def _told(rows: Rows, top: Ids, family: Sequence[Ids], shares: Mapping[str, float]) -> bool:
    """Whether the data tell one of a family from the others, whose laws are off by a share of what they explain.

    The one that leads is off by no more than what it leaves here (two standard deviations of chi^2 above that): another law would
    have to be off in just the way that this one fits as far as the noise. Of a pair only the members' own part counts. Beside what an accepted
    model is known to leave, laws are off by at least as much as that is of the error now.
    """
    evidence = {c.ids: c.evidence for c in rows.candidates}
    lead = next(c for c in rows.candidates if c.ids == top)
    left = max(lead.chi2 - 1.0, 0.0) * rows.log.samples / 2.0 + 2.0 * float(np.sqrt(rows.log.samples / 2.0))
    share = max(shares.get(title(i), 0.0) for i in top)
    before = float(np.sqrt(1.0 - rows.log.grown)) if rows.scatters and rows.log.grown is not None else 0.0

    def told(other: Ids) -> bool:
        own = _own(lead, other, rows)
        # where no share will do, members are never named
        off = max(min(share, float(np.sqrt(left / max(own, 1.0)))) if share < 1.0 else share, before)
        return discounted(lead.evidence - evidence[other], off, own) > DECIDES_NATS

    return all(told(k) for k in family if k != top)


def _tied(rows: Rows, top: Ids) -> list[Ids]:
    """Return the models that the data do not put behind the most probable one: what is usual elsewhere does not decide here."""
    best = next((c for c in rows.candidates if c.ids == top and c.kind == OUTPUT), None)
    if best is None:
        return []
    # more effects are charged for in their evidence already; with all of the top one's, or their like, among them they do not contradict it
    own, zero = {title(i) for i in top}, {with_zeros(i) for i in top}

    def contains(c: CandidateRow) -> bool:
        return own <= {title(i) for i in c.ids} or (len(c.ids) > len(top) and zero <= {with_zeros(i) for i in c.ids})

    # what joins has to add what any further effect has to
    others = [(c, JOINS_NATS * max(len(c.ids) - len(top), 0)) for c in rows.named.candidates if c.kind == OUTPUT and not contains(c)]
    return [c.ids for c, joins in others if c.evidence - joins > best.evidence - DECIDES_NATS]


def _set(ranked: Sequence[Ids], p: Mapping[Ids, float], least: float) -> tuple[Ids, ...]:
    """Return the candidates whose part of the named probability is not below the learned one (Sadinle, Lei, Wasserman 2019)."""
    named = sum(p[k] for k in ranked)
    return tuple(k for i, k in enumerate(ranked) if i == 0 or p[k] >= least * named)


def _nearer(group: Sequence[Ids], rows: Rows) -> tuple[Ids, ...]:
    """Return a set, the most probable first, without models of the output that bring it no nearer: evidence beside a loose model is not enough."""
    share = {c.ids: nearer(c, rows) for c in rows.candidates if c.kind == OUTPUT}
    return tuple(k for i, k in enumerate(group) if i == 0 or share.get(k, 1.0) > LEAST_SHARE)


def _runner_up(p: Mapping[Ids, float]) -> str:
    rest = {NONE: "nothing at all", UNKNOWN: "something that has no name here"}
    return rest[NONE if p[NONE] >= p[UNKNOWN] else UNKNOWN]

"""Learn the verdict's weights from a library of cases: a penalised conditional multinomial model, one simulator left out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar
from scipy.special import log_softmax, softmax
from sklearn.isotonic import IsotonicRegression

from sstl_cli.blind.truth import CaseTruth
from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN
from sstl_cli.diagnosis.constants import DECIDABLE, LEAST_GAP, MISFITS, SHARES, TOLD, USUAL_SHARE
from sstl_cli.diagnosis.evidence import discounted
from sstl_cli.diagnosis.features import OUTPUT, Ids, Rows
from sstl_cli.diagnosis.hypotheses import FAMILIES
from sstl_cli.diagnosis.verdict import (
    AMBIGUOUS,
    CANDIDATE_TERMS,
    IDENTIFIED,
    LOG_TERMS,
    NOTHING,
    UNDECIDED,
    Verdict,
    candidate_terms,
    decided,
    inclusive,
    log_terms,
    probabilities,
    standing,
)
from sstl_cli.diagnosis.weights import Weights
from sstl_cli.physics.effects import catalogue

Array = NDArray[np.float64]
# standard deviation of the weights beforehand: terms are of order one; effects differ less than what is seen of them
PRIOR_TERM, PRIOR_EFFECT = 1.5, 0.7
# and of how far the weights beside an accepted model are from those without: its cases are fewer
PRIOR_APART = 0.6
# more evidence never speaks against a candidate, nor more of what it leaves for it: terms whose weight has one sign
FOR = {
    "behind",
    "ahead",
    "weak_part",
    "recorder_share",
    "recorder_gain",
    "beside_gain",
    "beside_share",
    *(f"log_behind_{m:g}" for m in MISFITS),
}
AGAINST = {"rank", "left_share", "little", "means", "outside", "unstable", "strengths", "recorder_out", "beside_out"}
WRONG_COMMITS, FALSE_ALARMS, COVERAGE, WRONG_MEMBERS = 0.02, 0.02, 0.92, 0.05
# kinds of the cases whose effect is no candidate: drawn so, and searched again without it
EXCLUDED, WITHOUT = "excluded", "without"
SCHEMA = "sstl.weights/1"
# what is learned of terms and effects; thresholds are set once, on all simulators that were left out
TERMS = ("candidate", "none", "unknown", "effect")
STATUSES = (IDENTIFIED, AMBIGUOUS, UNDECIDED, NOTHING)
COMMITS = np.linspace(0.5, 0.98, 25)
# a library of few cases does not make odds twice as sure
TEMPERS = (0.2, 2.0)
# fewer cases say nothing of how often a verdict is right
FEWEST_STATED = 50
# half of D^2 = 24: naming at 49 to 1 in 95 of 100 cases
DECIDABLE_NATS = 0.5 * DECIDABLE


@dataclass(frozen=True)
class Example:
    """One case of a library: its rows, what should be said of it, and where it comes from."""

    name: str
    simulator: str
    kind: str
    strength: float
    rows: Rows
    answer: Ids


# examples with the probabilities that simulators which were left out gave them
Judged = Sequence[tuple[Example, Mapping[Ids, float]]]


@dataclass(frozen=True)
class _Design:
    """One example as matrices: terms and effects of the candidates side by side, terms of the log, index of the answer."""

    candidates: Array
    log: Array
    answer: int


def examples(cases: Iterable[Example]) -> list[Example]:
    """Return the cases that say something, with the candidates that stand: neither on poor movements nor with what nobody could see."""
    seen = (c for c in cases if c.kind != "poor" and (c.answer == NONE or c.strength >= LEAST_GAP))
    return [replace(case, rows=standing(case.rows)) for case in seen]


def answerable(e: Example) -> bool:
    """Whether the right answer is among those that can be given."""
    return e.answer in (NONE, UNKNOWN) or any(c.ids == e.answer for c in e.rows.candidates)


def right_answer(truth: CaseTruth) -> Ids:
    """Return what should be said of a case."""
    if truth.excluded or truth.unlisted:
        return tuple(sorted(truth.also)) or UNKNOWN
    return tuple(sorted(truth.effects))


def without_answer(e: Example) -> Example | None:
    """Return the example as it is where its effect is no candidate: then the answer is that nobody knows.

    None where what is left explains the log about as well. Of a case that was drawn without its effect nobody can say that.
    What a fault of the recorder has hurt is masked, whether or not it may be named; of a channel beside no row tells without its effect.
    """
    if e.answer in (NONE, UNKNOWN) or e.strength < 0.6:
        return None
    if all(c.kind != OUTPUT for c in e.rows.candidates if c.ids == e.answer):
        return None
    kept = tuple(c for c in e.rows.candidates if not set(c.ids) & set(e.answer))
    if not any(c.kind == OUTPUT for c in kept):
        return None
    own = next(c.evidence for c in e.rows.candidates if c.ids == e.answer)
    if discounted(own - max(c.evidence for c in kept), USUAL_SHARE, own) < DECIDABLE_NATS:
        # what is left explains the log as well, as far as any law is exact: nobody could say that something is missing
        return None
    return replace(e, name=f"{e.name}-without", kind=WITHOUT, rows=replace(e.rows, candidates=kept), answer=UNKNOWN)


def _design(e: Example) -> _Design:
    names = sorted(catalogue())
    candidates = [np.concatenate((candidate_terms(c, e.rows), [float(n in c.ids) for n in names])) for c in e.rows.candidates]
    ids = [c.ids for c in e.rows.candidates]
    answer = len(ids) if e.answer == NONE else len(ids) + 1 if e.answer == UNKNOWN else ids.index(e.answer)
    return _Design(np.reshape(candidates, (len(ids), len(CANDIDATE_TERMS) + len(names))), log_terms(e.rows), answer)


def learn(found: Sequence[Example], provenance: Mapping[str, object] | None = None, around: Weights | None = None) -> Weights:
    """Return the most likely weights; thresholds are left open (see :func:`calibrated`).

    Those of the candidates first, from the cases whose cause is one of them; then those of the log, of which the candidates'
    inclusive value is one number (the sequential estimator of McFadden 1978).

    Parameters
    ----------
    around : Weights, optional
        Where the weights are beforehand (default: at 0): those of cases that are like these in most.
    """
    designs = [_design(e) for e in found]
    c, names = len(CANDIDATE_TERMS), sorted(catalogue())
    start, spread = _beforehand(around)
    signed = [(0.0 if t in FOR else None, 0.0 if t in AGAINST else None) for t in CANDIDATE_TERMS]
    first = _likeliest(lambda w: _of_names(designs, w), start[0], spread[0], signed + [(None, None)] * len(names))
    seen = [replace(d, log=_with_inclusive(d, first)) for d in designs]
    falls = [(None, 0.0 if t == "inclusive" else None) for t in LOG_TERMS]
    second = _likeliest(lambda w: _of_kinds(seen, w), start[1], spread[1], falls * 2)

    def named(keys: Sequence[str], part: Array) -> dict[str, float]:
        return {k: round(float(v), 5) for k, v in zip(keys, part, strict=True)}

    return Weights(
        named(CANDIDATE_TERMS, first[:c]),
        named(LOG_TERMS, second[: len(LOG_TERMS)]),
        named(LOG_TERMS, second[len(LOG_TERMS) :]),
        named(names, first[c:]),
        0.5,
        dict.fromkeys(FAMILIES, 1.0),
        0.5,
        0.1,
        DECIDABLE,
        {},
        dict(provenance or {}),
    )


def _with_inclusive(d: _Design, weights: Array) -> Array:
    return np.where([t == "inclusive" for t in LOG_TERMS], inclusive(d.candidates @ weights), d.log)


def _likeliest(cost: Callable[[Array], tuple[float, Array]], start: Array, spread: Array, bounds: Sequence[Any]) -> Array:
    """Return the most likely weights by a cost (minus log likelihood) with its gradient, normal about ``start`` beforehand."""

    def posterior(w: Array) -> tuple[float, Array]:
        total, gradient = cost(w)
        off = (w - start) / spread
        return total + 0.5 * float(off @ off), gradient + off / spread

    return np.asarray(minimize(posterior, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 500}).x)


def _of_names(designs: Sequence[_Design], w: Array) -> tuple[float, Array]:
    """Return minus the log likelihood of the names that were right, and its gradient, by weights of terms and effects."""
    total, gradient = 0.0, np.zeros(len(w))
    for d in designs:
        if d.answer < len(d.candidates):
            q = softmax(d.candidates @ w)
            total -= float(np.log(max(q[d.answer], 1e-300)))
            q[d.answer] -= 1.0
            gradient += d.candidates.T @ q
    return total, gradient


def _of_kinds(designs: Sequence[_Design], w: Array) -> tuple[float, Array]:
    """Return minus the log likelihood of whether nothing, something unnamed or a candidate was right, and its gradient."""
    none, unknown = np.split(w, 2)
    total, gradient = 0.0, np.zeros((2, len(none)))
    for d in designs:
        count = len(d.candidates)
        kind = 0 if d.answer < count else d.answer - count + 1
        p = softmax(np.array([0.0 if count else -np.inf, none @ d.log, unknown @ d.log]))
        total -= float(np.log(max(p[kind], 1e-300)))
        p[kind] -= 1.0
        gradient += np.outer(p[1:], d.log)
    return total, gradient.ravel()


def _beforehand(around: Weights | None) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return mean and standard deviation of all weights before any case is seen, of the candidates and of the log."""
    names = sorted(catalogue())
    own, logs = np.zeros(len(CANDIDATE_TERMS) + len(names)), np.zeros(2 * len(LOG_TERMS))
    if around is None:
        return (own, logs), (np.repeat((PRIOR_TERM, PRIOR_EFFECT), (len(CANDIDATE_TERMS), len(names))), np.full(len(logs), PRIOR_TERM))
    own = np.array([*(around.candidate[t] for t in CANDIDATE_TERMS), *(around.effect[n] for n in names)])
    logs = np.array([part[t] for part in (around.none, around.unknown) for t in LOG_TERMS])
    return (own, logs), (np.full(len(own), PRIOR_APART), np.full(len(logs), PRIOR_APART))


def left_out(found: Sequence[Example], around: Mapping[str, Weights] | None = None) -> dict[str, Weights]:
    """Return for each simulator the weights learned from the others, beforehand where those without it are ``around``."""
    simulators = sorted({e.simulator for e in found})
    return {s: learn([e for e in found if e.simulator != s], around=around[s] if around else None) for s in simulators}


def judged_by(found: Sequence[Example], others: Mapping[str, Weights]) -> Judged:
    """Return examples as weights of the other simulators judge them."""
    return [(e, probabilities(e.rows, others[e.simulator])) for e in found]


def calibrated(judged: Judged, weights: Weights, drawn: Judged, more: Judged = ()) -> Weights:
    """Return weights with thresholds and reliability from predictions of simulators that were left out.

    Parameters
    ----------
    drawn : sequence of (example, probabilities)
        All cases as they were drawn, with causes that no candidate has and nobody could tell: what is stated, and how often a name
        is wrong, counts over those, as a user meets them.
    more : sequence of (example, probabilities), optional
        Cases of another question that say as well by how much the laws of a family's members are off.
    """
    bare = replace(weights, quiet=_quiet(judged), cover=_cover(judged), reliability={})
    bare = replace(bare, member={title: _member(set(members), [*judged, *more], bare) for title, members in FAMILIES.items()})
    bare = replace(bare, commit=_threshold(drawn, bare))
    said = [(e, decided(e.rows, p, bare)) for e, p in drawn]
    return replace(bare, shows_d2=_shows(said), reliability=_by_status(said), temper=_temper(drawn))


def _temper(drawn: Judged) -> float:
    """Return the power of the odds between a cause with a name, none and one without that makes the answers of all cases likeliest."""
    ends = [(p[NONE], p[UNKNOWN]) for _, p in drawn]
    odds = np.log(np.clip([(1.0 - none - unknown, none, unknown) for none, unknown in ends], np.finfo(float).tiny, 1.0))
    answers = np.array([(NONE, UNKNOWN).index(e.answer) + 1 if e.answer in (NONE, UNKNOWN) else 0 for e, _ in drawn])

    def cost(power: float) -> float:
        return float(-log_softmax(power * odds, axis=1)[np.arange(len(answers)), answers].sum())

    return round(float(minimize_scalar(cost, bounds=TEMPERS, method="bounded").x), 3)


def _member(family: set[str], judged: Judged, weights: Weights) -> float:
    """Return by which share the laws of a family's members are off: at most ``WRONG_MEMBERS`` of those named are another one.

    No share will do where so few are named that none of them may be wrong: members are then never named.
    """
    inside = [(e, p) for e, p in judged if e.answer and set(e.answer) <= family]
    for share in SHARES:
        tried = replace(weights, commit=float(COMMITS[0]), member=dict.fromkeys(FAMILIES, share))
        said = [(e, decided(e.rows, p, tried)) for e, p in inside]
        named = [(e, v) for e, v in said if v.status == IDENTIFIED and set(v.effects) <= family]
        allowed = WRONG_MEMBERS * len(named)
        if allowed >= 1.0 and sum(is_wrong(e, v) for e, v in named) <= allowed:
            return share
    return 1.0


def _threshold(drawn: Judged, weights: Weights) -> float:
    """Return the smallest probability from which on at most ``WRONG_COMMITS`` of the cases that lack something are committed to wrongly.

    Where nothing is missing any name is a false alarm: such cases would only dilute the share.
    """
    lacking = [(e, p) for e, p in drawn if e.answer != NONE]
    for commit in COMMITS:
        tried = replace(weights, commit=float(commit))
        if sum(is_wrong(e, decided(e.rows, p, tried)) for e, p in lacking) <= WRONG_COMMITS * len(lacking):
            return round(float(commit), 6)
    return float(COMMITS[-1])


def _shows(said: Sequence[tuple[Example, Verdict]]) -> float:
    """Return the squared distance to nothing from which on a single effect is taken for nothing in fewer than 1 - ``TOLD`` of cases.

    What it gains is half of that on average; a verdict charges for its strengths, and for all that might be there instead.
    """
    single = [(e, v) for e, v in said if len(e.answer) == 1]
    own = [(c.gain, float(v.status != NOTHING)) for e, v in single for c in e.rows.candidates if c.ids == e.answer and c.kind == OUTPUT]
    if len(own) < FEWEST_STATED:
        return DECIDABLE
    gains, found = np.array(own).T
    told = gains[IsotonicRegression(y_min=0.0, y_max=1.0).fit(gains, found).predict(gains) >= TOLD]
    return round(max(2.0 * float(told.min()), DECIDABLE), 1) if told.size else DECIDABLE


def _quiet(judged: Judged) -> float:
    """Return the probability of ``none`` from which on nothing is named: all but ``FALSE_ALARMS`` of the nulls have it."""
    nulls = [p[NONE] for e, p in judged if e.answer == NONE]
    return round(float(np.clip(np.quantile(nulls, FALSE_ALARMS), 0.02, 0.5)), 6) if nulls else 0.5


def _cover(judged: Judged) -> float:
    """Return the part of the named probability that a candidate needs to be in a set (the worst simulator's quantile)."""
    parts: dict[str, list[float]] = {}
    for e, p in judged:
        if e.answer in (NONE, UNKNOWN):
            continue
        named = sum(q for k, q in p.items() if k not in (NONE, UNKNOWN))
        parts.setdefault(e.simulator, []).append(p[e.answer] / max(named, 1e-300))
    worst = min((float(np.quantile(v, 1.0 - COVERAGE)) for v in parts.values()), default=0.1)
    return round(float(np.clip(worst - 1e-6, 1e-6, 0.5)), 6)


def is_right(e: Example, said: Any) -> bool:
    """Whether a verdict is right: the truth is in its set, or the right kind of no."""
    if said.status in ("identified", "ambiguous"):
        covered = {i for ids in said.group for i in ids}
        return e.answer not in (NONE, UNKNOWN) and set(e.answer) <= covered
    return e.answer == (NONE if said.status == "none" else UNKNOWN)


def is_wrong(e: Example, said: Verdict) -> bool:
    """Whether a verdict commits to a name that is not the cause."""
    return said.status == IDENTIFIED and not set(said.effects) <= set(e.answer)


def _by_status(said: Sequence[tuple[Example, Verdict]]) -> dict[str, tuple[tuple[float, float], ...]]:
    """Return for each status what was stated and the share that was right; of all together where there are too few of one."""
    every = _reliability(said)
    own = {s: _reliability([(e, v) for e, v in said if v.status == s]) for s in STATUSES}
    return {s: rows or every for s, rows in own.items()}


def _reliability(said: Sequence[tuple[Example, Any]]) -> tuple[tuple[float, float], ...]:
    """Return stated probability against share of right verdicts, monotone (Zadrozny and Elkan 2002).

    Of a level that k of n verdicts have the rule of succession tells (k + 1) / (n + 2): where three of three were right nobody
    knows that all will be.
    """
    x = np.array([v.confidence for _, v in said if v.confidence is not None])
    y = np.array([is_right(e, v) for e, v in said if v.confidence is not None], float)
    if len(x) < FEWEST_STATED:
        return ()
    level = IsotonicRegression().fit_transform(x, y)
    _, block = np.unique(level, return_inverse=True)
    count = np.bincount(block)
    told = ((np.bincount(block, y) + 1.0) / (count + 2.0))[block]
    # a small block may tell less than one below it: together they are one
    fitted = IsotonicRegression(out_of_bounds="clip").fit(x, told)
    grid = np.quantile(x, np.linspace(0.02, 0.98, 9))
    return tuple((round(float(a), 4), round(float(b), 4)) for a, b in zip(grid, fitted.predict(grid), strict=True) if np.isfinite(b))


def to_document(w: Weights) -> dict[str, object]:
    """Return weights as their document (``weights.json``)."""
    return {
        "schema": SCHEMA,
        "provenance": dict(w.provenance),
        "commit": w.commit,
        "member": dict(w.member),
        "quiet": w.quiet,
        "cover": w.cover,
        "shows_d2": w.shows_d2,
        "temper": w.temper,
        "reliability": {status: [list(r) for r in rows] for status, rows in w.reliability.items()},
        "candidate": dict(w.candidate),
        "none": dict(w.none),
        "unknown": dict(w.unknown),
        "effect": dict(w.effect),
        **({} if not w.without else {"without": {s: {t: dict(getattr(other, t)) for t in TERMS} for s, other in w.without.items()}}),
        **({} if w.known is None else {"known": to_document(w.known)}),
    }

"""Learn the verdict's weights from a library of cases: a penalised conditional multinomial model, one simulator left out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from sklearn.isotonic import IsotonicRegression

from sstl_cli.diagnosis.features import OUTPUT, Rows
from sstl_cli.diagnosis.verdict import (
    CANDIDATE_TERMS,
    LOG_TERMS,
    NONE,
    UNKNOWN,
    Ids,
    Weights,
    candidate_terms,
    leading,
    log_terms,
    probabilities,
    size,
    standing,
    verdict,
)
from sstl_cli.physics.effects import catalogue

Array = NDArray[np.float64]
# standard deviation of the weights beforehand: terms are of order one; effects differ less than what is seen of them
PRIOR_TERM, PRIOR_EFFECT = 1.5, 0.7
WRONG_COMMITS, FALSE_ALARMS, COVERAGE = 0.015, 0.02, 0.92
LEAST_STRENGTH = 0.1
# nulls whose best model is larger than what is called small
CHANCE = 0.05


@dataclass(frozen=True)
class Example:
    """One case of the library: its rows, the right answer, and where it comes from."""

    name: str
    simulator: str
    kind: str
    strength: float
    rows: Rows
    answer: Ids


@dataclass(frozen=True)
class _Design:
    """One example as matrices: terms and effects of the candidates, terms of the log, index of the answer."""

    terms: Array
    effects: Array
    log: Array
    answer: int


def examples(cases: Iterable[tuple[str, Mapping[str, Any], Rows]]) -> list[Example]:
    """Return the examples of a library; cases whose answer cannot be given are left out.

    Parameters
    ----------
    cases : iterable of (name, truth, rows)
    """
    found = []
    for name, truth, rows in cases:
        answer = right_answer(truth)
        strength = float(truth["strength"])
        hidden = bool(truth["effects"]) and strength < LEAST_STRENGTH
        rows = standing(rows)
        known = {c.ids for c in rows.candidates} | {NONE, UNKNOWN}
        if hidden or truth["poor"] or answer not in known:
            continue
        found.append(Example(name, truth["simulator"], truth["kind"], strength, rows, answer))
    return found


def right_answer(truth: Mapping[str, Any]) -> Ids:
    """Return what should be said of a case."""
    if truth["excluded"] or truth["unlisted"]:
        return UNKNOWN
    return tuple(sorted(truth["effects"]))


def without_answer(e: Example) -> Example | None:
    """Return the example as it is where its effect is no candidate: then the answer is that nobody knows."""
    if e.answer in (NONE, UNKNOWN) or e.strength < 0.6:
        return None
    kept = tuple(c for c in e.rows.candidates if not set(c.ids) & set(e.answer))
    if not any(c.kind == OUTPUT for c in kept):
        return None
    return replace(e, name=f"{e.name}-without", kind="excluded", rows=replace(e.rows, candidates=kept), answer=UNKNOWN)


def _design(e: Example) -> _Design:
    names = sorted(catalogue())
    terms = np.array([candidate_terms(c, e.rows) for c in e.rows.candidates])
    effects = np.array([[float(n in c.ids) for n in names] for c in e.rows.candidates])
    ids = [c.ids for c in e.rows.candidates]
    answer = len(ids) if e.answer == NONE else len(ids) + 1 if e.answer == UNKNOWN else ids.index(e.answer)
    return _Design(terms, effects, log_terms(e.rows), answer)


def learn(found: Sequence[Example], provenance: Mapping[str, Any] | None = None) -> Weights:
    """Return the most likely weights; thresholds are left open (see :func:`calibrated`)."""
    designs = [_design(e) for e in found]
    c, log, names = len(CANDIDATE_TERMS), len(LOG_TERMS), sorted(catalogue())
    spread = np.concatenate((np.full(c + 2 * log, PRIOR_TERM), np.full(len(names), PRIOR_EFFECT)))

    def cost(w: Array) -> tuple[float, Array]:
        own, none, unknown, effect = w[:c], w[c : c + log], w[c + log : c + 2 * log], w[c + 2 * log :]
        total, gradient = 0.0, np.zeros(len(w))
        for d in designs:
            score = np.concatenate((d.terms @ own + d.effects @ effect, [none @ d.log, unknown @ d.log]))
            score -= score.max()
            p = np.exp(score)
            p /= p.sum()
            total -= float(np.log(max(p[d.answer], 1e-300)))
            p[d.answer] -= 1.0
            gradient[:c] += d.terms.T @ p[:-2]
            gradient[c + 2 * log :] += d.effects.T @ p[:-2]
            gradient[c : c + log] += p[-2] * d.log
            gradient[c + log : c + 2 * log] += p[-1] * d.log
        return total + 0.5 * float(np.sum((w / spread) ** 2)), gradient + w / spread**2

    w = minimize(cost, np.zeros(len(spread)), jac=True, method="L-BFGS-B", options={"maxiter": 500}).x

    def named(keys: Sequence[str], part: Array) -> dict[str, float]:
        return {k: round(float(v), 5) for k, v in zip(keys, part, strict=True)}

    return Weights(
        named(CANDIDATE_TERMS, w[:c]),
        named(LOG_TERMS, w[c : c + log]),
        named(LOG_TERMS, w[c + log : c + 2 * log]),
        named(names, w[c + 2 * log :]),
        0.5,
        0.5,
        0.0,
        0.1,
        (),
        dict(provenance or {}),
    )


def left_out(found: Sequence[Example]) -> dict[str, Weights]:
    """Return for each simulator the weights learned from the others."""
    return {s: learn([e for e in found if e.simulator != s]) for s in sorted({e.simulator for e in found})}


def calibrated(found: Sequence[Example], weights: Weights, others: Mapping[str, Weights]) -> Weights:
    """Return weights with thresholds and reliability from predictions of simulators that were left out."""
    judged = [(e, probabilities(e.rows, others[e.simulator])) for e in found]
    tops = []
    for e, p in judged:
        top = max((k for k in p if k not in (NONE, UNKNOWN)), key=lambda k: p[k], default=NONE)
        tops.append((p.get(top, 0.0), top == e.answer or (set(top) < set(e.answer) and e.answer not in (NONE, UNKNOWN))))
    commit, quiet, cover = _threshold(tops, len(judged)), _quiet(judged), _cover(judged)
    small = _small(found)
    bare = {s: replace(w, commit=commit, quiet=quiet, small=small, cover=cover, reliability=()) for s, w in others.items()}
    said = [(e, verdict(e.rows, bare[e.simulator])) for e in found]
    return replace(weights, commit=commit, quiet=quiet, small=small, cover=cover, reliability=_reliability(said))


def _threshold(tops: Sequence[tuple[float, bool]], cases: int) -> float:
    """Return the smallest probability from which on at most ``WRONG_COMMITS`` of all cases are committed to wrongly."""
    wrong, commit = 0, 0.5
    for p, right in sorted(tops, reverse=True):
        wrong += not right
        if wrong > WRONG_COMMITS * cases:
            commit = p
            break
    return round(float(np.clip(commit + 1e-6, 0.5, 0.9999)), 6)


def _quiet(judged: Sequence[tuple[Example, Mapping[Ids, float]]]) -> float:
    """Return the probability of ``none`` from which on nothing is named: all but ``FALSE_ALARMS`` of the nulls have it."""
    nulls = [p[NONE] for e, p in judged if e.answer == NONE]
    return round(float(np.clip(np.quantile(nulls, FALSE_ALARMS), 0.02, 0.5)), 6) if nulls else 0.5


def _small(found: Sequence[Example]) -> float:
    """Return the size (over the noise) that the best model reaches in all but ``CHANCE`` of the nulls."""
    sizes = [size(leading(standing(e.rows)), e.rows.log) for e in found if e.answer == NONE]
    fitted = [s for s in sizes if np.isfinite(s)]
    return round(float(np.quantile([*fitted, *[0.0] * (len(sizes) - len(fitted))], 1.0 - CHANCE)), 6) if sizes else 0.0


def _cover(judged: Sequence[tuple[Example, Mapping[Ids, float]]]) -> float:
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


def _reliability(said: Sequence[tuple[Example, Any]]) -> tuple[tuple[float, float], ...]:
    """Return stated probability against share of right verdicts, monotone (Zadrozny and Elkan 2002)."""
    x = np.array([v.confidence for _, v in said if v.confidence is not None])
    y = np.array([is_right(e, v) for e, v in said if v.confidence is not None], float)
    if len(x) < 50:
        return ()
    fitted = IsotonicRegression(y_min=0.02, y_max=0.995, out_of_bounds="clip").fit(x, y)
    grid = np.quantile(x, np.linspace(0.02, 0.98, 9))
    return tuple((round(float(a), 4), round(float(b), 4)) for a, b in zip(grid, fitted.predict(grid), strict=True) if np.isfinite(b))


def to_document(w: Weights) -> dict[str, Any]:
    """Return weights as their document (``weights.json``)."""
    return {
        "schema": "sstl.weights/1",
        "provenance": dict(w.provenance),
        "commit": w.commit,
        "quiet": w.quiet,
        "small": w.small,
        "cover": w.cover,
        "reliability": [list(r) for r in w.reliability],
        "candidate": dict(w.candidate),
        "none": dict(w.none),
        "unknown": dict(w.unknown),
        "effect": dict(w.effect),
    }

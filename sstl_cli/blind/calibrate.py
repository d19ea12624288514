"""The temperature that turns differences of held-out log scores into probabilities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from sstl_cli.core.errors import SstlError

Array = NDArray[np.float64]
SCHEMA = "sstl.blind.calibration/1"
RANGE = (0.05, 1e4)
FEWEST = 10
PRIOR_CASES = 4.0


@dataclass(frozen=True)
class Scored:
    """How far every model is behind the best one of a case (nats, 0 or less), and which one is true."""

    behind: Array
    true: int


def scored(truth: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> Scored | None:
    """Return the scores of a case; None where the truth is no single candidate, or no scores were kept.

    The base model stands for "nothing missing". Where the diagnosis states how far a model counts as being behind
    (``behind_nats``, discounted where blocks disagree) that is used, else the difference of the scores.
    """
    if truth["poor"] or truth["excluded"] or truth["unlisted"] or len(truth["effects"]) > 1:
        return None
    rows = [("", diagnosis.get("base_score"), diagnosis.get("base_behind_nats"))]
    rows += [(c["id"], c.get("score"), c.get("behind_nats")) for c in diagnosis["candidates"] if "+" not in c["id"]]
    rows = [r for r in rows if r[1] is not None]
    names = [r[0] for r in rows]
    wanted = next(iter(truth["effects"]), "")
    if wanted not in names or len(rows) < 2:
        return None
    if all(r[2] is not None for r in rows):
        behind = -np.abs(np.array([float(r[2]) for r in rows]))  # type: ignore[arg-type]
    else:
        score = np.array([float(r[1]) for r in rows])  # type: ignore[arg-type]
        behind = score - score.max()
    return Scored(behind, names.index(wanted))


def loss(cases: Sequence[Scored], temperature: float) -> float:
    """Return the mean negative log probability that the true models get (nats)."""
    total = 0.0
    for c in cases:
        x = c.behind / temperature
        total += float(np.logaddexp.reduce(x) - x[c.true])
    return total / len(cases)


def temperature(cases: Sequence[Scored]) -> float:
    """Return the temperature of least loss (Guo et al. 2017, temperature scaling).

    Raises
    ------
    SstlError
        If the library holds too few cases whose truth is a candidate.
    """
    if len(cases) < FEWEST:
        raise SstlError(
            f"only {len(cases)} cases of the library can be used, {FEWEST} are needed",
            fix="make a larger library and run it",
            code="E955",
        )
    grid = np.linspace(float(np.log(RANGE[0])), float(np.log(RANGE[1])), 60)
    best = int(np.argmin([loss(cases, float(np.exp(g))) for g in grid]))
    bounds = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
    found = minimize_scalar(lambda g: loss(cases, float(np.exp(g))), bounds=bounds, method="bounded")
    return float(np.exp(found.x))


def verdicts(evidence: Sequence[str], right: Sequence[bool]) -> dict[str, dict[str, float]]:
    """Return how often each kind of evidence was right, drawn to the share of its status as if by four more cases.

    The share of a status is drawn to one half by two more cases (Laplace's rule of succession).
    """
    found = {}
    for kind in sorted(set(evidence) - {""}):
        status = kind.partition("/")[0]
        alike = [r for e, r in zip(evidence, right, strict=True) if e.partition("/")[0] == status]
        prior = (sum(alike) + 1) / (len(alike) + 2)
        hits = [r for e, r in zip(evidence, right, strict=True) if e == kind]
        found[kind] = {"cases": len(hits), "right": (sum(hits) + PRIOR_CASES * prior) / (len(hits) + PRIOR_CASES)}
    return found

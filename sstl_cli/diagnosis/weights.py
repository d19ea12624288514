"""The weights of the verdict and what is said at which probability: learned on simulators of several kinds.

``weights.json`` holds them, and says what they were learned from.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Weights:
    """Learned weights by term, thresholds, and where they come from; ``known`` are those beside an accepted model,
    ``without`` those that a simulator's cases were left out of, with the same thresholds.

    ``temper`` is the power of the odds between a cause with a name, none and one without at which they are as often right as they say.
    ``shows_d2`` is the squared distance to nothing from which on an effect is hardly ever taken for nothing; ``reliability`` has for each status what was stated, and the share of such verdicts that were right.
    """

    candidate: Mapping[str, float]
    none: Mapping[str, float]
    unknown: Mapping[str, float]
    effect: Mapping[str, float]
    commit: float
    member: Mapping[str, float]
    quiet: float
    cover: float
    shows_d2: float
    reliability: Mapping[str, tuple[tuple[float, float], ...]]
    provenance: Mapping[str, Any] = field(default_factory=dict)
    known: Weights | None = None
    temper: float = 1.0
    without: Mapping[str, Weights] = field(default_factory=dict)

    @property
    def seeds(self) -> list[tuple[int, int]]:
        """Inclusive ranges of the seeds of all cases that were learned from."""
        own = [(int(a), int(b)) for a, b in self.provenance.get("seeds", ())]
        return own if self.known is None else [*own, *self.known.seeds]

    def right(self, status: str, p: float) -> float:
        """Return the share of verdicts of a status with this probability that were right, the probability where nobody tried."""
        told = self.reliability.get(status)
        if not told:
            return p
        x, y = zip(*told, strict=True)
        return float(np.interp(p, x, y))


@cache
def learned(accepted: bool = False) -> Weights:
    """Return the weights that come with the package; those for what has changed since a model was accepted, if asked for."""
    text = resources.files("sstl_cli.diagnosis").joinpath("weights.json").read_text("utf-8")
    weights = from_document(json.loads(text))
    return weights if not accepted or weights.known is None else weights.known


def from_document(d: Mapping[str, Any]) -> Weights:
    """Return weights from their document."""
    found = Weights(
        d["candidate"],
        d["none"],
        d["unknown"],
        d["effect"],
        d["commit"],
        d["member"],
        d["quiet"],
        d["cover"],
        d["shows_d2"],
        {status: tuple((float(a), float(b)) for a, b in rows) for status, rows in d["reliability"].items()},
        d["provenance"],
        from_document(d["known"]) if "known" in d else None,
        d.get("temper", 1.0),
    )
    return replace(found, without={s: replace(found, **terms) for s, terms in d.get("without", {}).items()})

"""The evidence of a diagnosis with what is said of it: the verdict, and the model that is accepted for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sstl_cli.diagnosis.faults import RecorderEffect
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.gathering import Evidence
from sstl_cli.diagnosis.verdict import AMBIGUOUS, IDENTIFIED, Verdict


@dataclass(frozen=True, kw_only=True)
class Judged(Evidence):
    """All that was found, the verdict on it, and the fit of the accepted model."""

    verdict: Verdict
    accepted: Fit

    @property
    def fault(self) -> RecorderEffect | None:
        """The fault of the recorder that is named, if one is."""
        return next((r for r in self.recorder if (r.id,) == self.verdict.effects), None)


def by_size(g: Judged) -> list[str]:
    """Return the named effects, the one whose removal changes the prediction most first."""
    effects = list(g.verdict.effects)
    if g.verdict.status not in (IDENTIFIED, AMBIGUOUS) or len(effects) < 2:
        return effects
    f = g.accepted

    def loss(effect_id: str) -> float:
        without = {k: v for k, v in f.effects.items() if k != effect_id}
        return float(np.sum((f.prediction - g.search.sim.predict(f.theta, without)) ** 2))

    return sorted(effects, key=lambda e: -loss(e))

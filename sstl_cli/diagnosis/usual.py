"""What an accepted rig is usually off by is no change of it, however its answer bends.

In the covariance of a later record a rig varies along straight lines (see wander). What effects do to a line that slides and
holds is not straight: a strength that is off by no more than is usual may leave, of what it does, more than any noise. So
the simulator as it was accepted is also asked at the strengths that a candidate has, at the price of their being there: half
their square over their usual variance (the prior's share of a Laplace evidence).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.found import Search


def beyond(found: Search) -> Search:
    """Return a search whose evidence is over the simulator as it usually is, not only as it was accepted: the same for all models."""
    if not found.sim.usual:
        return found
    least = max((w.evidence - _price(found, w) for w in found.ranked()), default=0.0)
    if least <= 0.0:
        return found

    def over(w: Weighed) -> Weighed:
        return replace(w, evidence=w.evidence - least)

    singles = {k: tuple(over(w) for w in v) for k, v in found.singles.items()}
    return replace(found, singles=singles, combined={k: over(w) for k, w in found.combined.items()})


def _price(found: Search, w: Weighed) -> float:
    """Return what it costs (nats) that a rig is off by the strengths of a model without a change; infinite where one is not known to vary."""
    strengths = [(x, v) for x, v in zip(w.fit.free, w.fit.values, strict=True) if not x.parameter.shape]
    sizes = [found.sim.usual.get((x.effect.id, x.parameter.name), 0.0) for x, _ in strengths]
    if not strengths or min(sizes) <= 0.0:
        return float("inf")
    return 0.5 * float(np.sum([((v - x.parameter.neutral) / s) ** 2 for (x, v), s in zip(strengths, sizes, strict=True)]))

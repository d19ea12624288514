"""Whether a bend has changed since a model was accepted: theta then, and beside what is named now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import DECIDES_NATS, HALF
from sstl_cli.diagnosis.evidence import discounted, strengths_charge
from sstl_cli.diagnosis.fit import Fit, fit, held, normal_equations
from sstl_cli.diagnosis.found import NOTHING
from sstl_cli.diagnosis.judged import Judged
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.verdict import UNDECIDED

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Bends:
    """Theta (rad) of the accepted model by bend that it has seen, with what is named now where that has parameters, and whether it changed."""

    before: dict[str, float]
    with_effect: dict[str, float] | None
    changed: bool


def since(g: Judged, given_n: float, retuned_n: float, known_n: float = 0.0) -> Bends | None:
    """Return theta of a model that was accepted before, and whether it has changed; None without one.

    It has where the odds of one that is fitted are beyond doubt (49 to 1, each bend charged for). Where nothing is named it has to explain at
    least half of the squared error of the model as given; beside effects that are named it is theirs: alone it would follow them. What the model
    is known to leave makes its laws off by as much as that is of the error; and beside a set of causes it has changed only if it goes the same
    way whichever of them it is. Where what has changed has no name theta follows that as well: nothing is said of it.

    Parameters
    ----------
    given_n, retuned_n, known_n : float
        Errors (RMS, in one unit) of the model as given, re-tuned, and as it is known to leave.
    """
    had, f, sim = g.search.sim.accepted, g.accepted, g.search.sim
    if had is None:
        return None
    seen = [i for i, (a, n) in enumerate(zip(had, g.nominal, strict=True)) if a == n]
    nats = _lost(sim, f, had) if f.free else fit(sim, f.whiten, NOTHING, had, np.zeros(0), 0).cost - f.cost
    worth = nats - strengths_charge(len(seen), 2.0 * max(nats, 0.0))
    off = min(known_n / given_n, 1.0) if given_n > 0.0 else 0.0
    # a law that is off by a share of all that the effect explains may look like a bend
    whole = max(nats, g.search.base.cost - f.cost, 0.0)
    changed = bool(seen) and bool(discounted(worth, max(off, f.discrepancy), whole) > DECIDES_NATS) and _alike(g, had, seen)
    if g.verdict.status == UNDECIDED:
        changed = False
    elif not f.free:
        changed = changed and retuned_n**2 <= (1.0 - HALF) * given_n**2
    before, beside = ({g.problem.configs[i]: float(theta[i]) for i in seen} for theta in (had, f.theta))
    return Bends(before, beside if f.free else None, changed)


def _alike(g: Judged, had: Array, seen: Sequence[int]) -> bool:
    """Whether theta goes the same way beside every cause that is not ruled out."""
    own = (g.accepted.theta - had)[seen]
    members = [w.fit for w in g.search.ranked() if tuple(sorted(w.ids)) in g.verdict.group]
    return all(float((f.theta - had)[seen] @ own) > 0.0 for f in members)


def _lost(sim: Simulator, f: Fit, theta: Array) -> float:
    """Return what a fit loses (nats, to second order) at another theta, its own parameters following."""
    a, _ = normal_equations(sim, f.whiten(f.jacobian), np.zeros(len(f.residual)))
    a += 1e-9 * np.diag(np.diag(a) + 1e-12)
    return held(a, np.arange(len(theta)), theta - f.theta)[0]

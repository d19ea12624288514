"""Evidence beside a known scatter: gains over what the scatter itself makes of them.

The scatter of an accepted model (see misfit) is no sensor noise: it comes in bursts and remembers in its own way, and a
likelihood that takes it for a first-order process overstates what a parameter gains. By how much shows in the record: the
scores of a parameter, summed over stretches, would vary as its information says; they vary more, and the ratio is by what
its gain is too large (information sandwich; magnitude adjustment of Chandler and Bate 2007). What an effect gained on the
model's own record, where nothing had changed, is chance as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.constants import STRETCHES
from sstl_cli.diagnosis.evidence import Weighed, weigh
from sstl_cli.diagnosis.fit import Fit, normal_equations
from sstl_cli.diagnosis.search import Search
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Whitener

Array = NDArray[np.float64]


def tempered(found: Search) -> Search:
    """Return a search whose evidence is over what a known scatter makes of it; as it is where none is known."""
    sim = found.sim
    if all(r.misfit_n is None for r in sim.problem.records):
        return found
    known = _alike(found)
    singles = {k: tuple(sorted((_weighed(sim, w, known, found.base.theta) for w in v), key=lambda w: -w.evidence)) for k, v in found.singles.items()}
    alone = replace(found, singles=singles, combined={})
    for key, w in sorted(found.combined.items(), key=lambda item: len(item[0])):
        parts = [p for p in alone.ranked() if len(p.ids) == len(w.ids) - 1 and set(p.ids) < set(w.ids)]
        alone.combined[key] = _weighed(sim, w, known, found.base.theta, parts)
    return alone


def _alike(found: Search) -> dict[str, float]:
    """Return by how much the gain of each effect is known to exceed chance, shared by those that show alike.

    One effect must not come before another only because the scatter happened to lie along the other.
    """
    sim = found.sim
    shown = {}
    for effect_id, models in found.singles.items():
        f = models[0].fit
        own, _ = _own(sim, found.base.whiten(f.jacobian))
        response = own @ np.array([v - x.parameter.neutral for x, v in zip(f.free, f.values, strict=True)])
        shown[effect_id] = response / max(float(np.linalg.norm(response)), 1e-300)
    usual = {i: max(sim.dispersion.get(i, 1.0), 1.0) for i in shown}
    return {i: max(1.0, *(float(a @ b) ** 2 * usual[k] for k, b in shown.items())) for i, a in shown.items()}


def _weighed(sim: Simulator, w: Weighed, known: Mapping[str, float], base: Array, parts: list[Weighed] | None = None) -> Weighed:
    gain = w.gain / max(overstated(sim, w.fit), *(known.get(i, 1.0) for i in w.ids))
    # weigh takes a cost to compare with; the fit itself stays as it is
    return weigh(sim, w.fit, w.fit.cost + gain, parts or (), base)


def by_chance(sim: Simulator, models: Mapping[str, Fit], whiten: Whitener, remains: Array) -> dict[str, float]:
    """Return for each effect how much more than chance its parameters gain on what an accepted model leaves of its own record.

    Parameters
    ----------
    remains : ndarray, shape (samples,)
        What map and scatter leave of parts of the record that they were not made from (N).
    """
    found = {}
    r = whiten(remains)
    for effect_id, f in models.items():
        own, information = _own(sim, whiten(f.jacobian))
        score = own.T @ r
        gained = float(score @ np.linalg.lstsq(information, score, rcond=1e-10)[0])
        found[effect_id] = max(1.0, gained / max(len(f.free), 1))
    return found


def _own(sim: Simulator, j: Array) -> tuple[Array, Array]:
    """Return the whitened columns of a fit's free parameters without what theta follows, and their information."""
    configs = len(sim.problem.configs)
    a, _ = normal_equations(sim, j, np.zeros(len(j)))
    a += 1e-9 * np.diag(np.diag(a) + 1e-12)
    follow = np.linalg.solve(a[:configs, :configs], a[:configs, configs:])
    own = j[:, 1:] - j[:, :1] * follow[sim.config]
    information = own.T @ own
    return own, information + 1e-9 * np.diag(np.diag(information) + 1e-12)


def overstated(sim: Simulator, f: Fit) -> float:
    """Return by what factor the likelihood overstates the gain of a fit's free parameters, at least 1."""
    k = len(f.free)
    if not k:
        return 1.0
    own, information = _own(sim, f.whiten(f.jacobian))
    r = f.whiten(f.residual)
    scores = []
    for s in sim.slices():
        pieces = np.array_split(np.arange(s.start, s.stop), STRETCHES)
        scores += [own[p].T @ r[p] for p in pieces]
    varied = np.array(scores).T @ np.array(scores)
    ratio = np.linalg.lstsq(information, varied, rcond=1e-10)[0]
    return max(1.0, float(np.trace(ratio)) / k)

"""What simpler rules would have answered: they are what the verdict is compared with in the blind check, and what a model has to beat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.gap import Errors
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.simulator import Simulator

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Answers:
    """The effect with the smallest error, and the one of a BIC that takes errors for independent; None where none is better than nothing."""

    smallest_rmse: str | None
    iid_bic: str | None


def answers(found: Search, errors: Errors) -> Answers:
    """Return what simpler rules say of the single effects of a search."""
    singles = [v[0] for v in found.singles.values()]
    if not singles:
        return Answers(None, None)
    w = found.sim.weight
    n = max(float(w.sum()), 2.0)

    def bic(residual: Array, k: int) -> float:
        # an exact model leaves nothing at all
        return n * float(np.log(max(float(np.sum(w * residual**2)) / n, 1e-300))) + k * float(np.log(n))

    scores = {x.ids[0]: bic(x.fit.residual, len(x.fit.free)) for x in singles}
    best = min(scores, key=lambda k: scores[k])
    return Answers(
        smallest_rmse=min(singles, key=lambda x: errors.rms(x.fit.residual)).ids[0],
        iid_bic=best if scores[best] < bic(found.base.residual, 0) else None,
    )


def line_n(sim: Simulator, errors: Errors) -> float:
    """Return what one straight line a system from input to output leaves (N, RMS) of what is analysed, by least squares."""
    output, records = sim.y + errors.known, sim.problem.records
    left = np.zeros(len(output))
    for system in sim.problem.systems:
        own = [(r, s) for r, s in zip(records, sim.slices(), strict=True) if r.system == system]
        at = np.concatenate([np.arange(s.start, s.stop) for _, s in own])
        into = np.concatenate([block_mean(r.u, r.factor)[: len(r)] for r, _ in own])
        columns, root = np.stack((into, np.ones(len(into))), axis=1), np.sqrt(sim.weight[at])
        best = np.linalg.lstsq(columns * root[:, None], output[at] * root, rcond=None)[0]
        left[at] = output[at] - columns @ best
    return errors.rms(left)

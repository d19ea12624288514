"""The gap in numbers: errors before and after what is named, above the noise floor, and how surely they fall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis import misfit, recorded, shrink
from sstl_cli.diagnosis.constants import HALF, REDUCIBLE
from sstl_cli.diagnosis.floor import Floor, fine_n, floor, unrounded_n
from sstl_cli.diagnosis.judged import Judged
from sstl_cli.physics.rebased import MISSED

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """Held-out residuals of base and accepted model (N), and the white noise above the analysis rate (N)."""

    base: Array
    accepted: Array
    fine_n: float
    weight: Array
    known: Array

    def rms(self, residual: Array) -> float:
        """Return the RMS (N) of a residual at the full rate."""
        squared = np.sum(self.weight * residual**2) / max(float(self.weight.sum()), 1.0)
        return float(np.sqrt(squared + self.fine_n**2))


@dataclass(frozen=True)
class Sizes:
    """Errors (N, RMS) as given, re-tuned and with what is named, the floor below them, and the fall of the error in percent.

    ``known_n`` is what the simulator was known to leave; ``interval`` is of that fall, None where it has none; ``explained_pct`` the
    part of what is above the floor, None where next to nothing is; ``worse`` names regions whose error grew.
    """

    given_n: float
    retuned_n: float
    with_effect_n: float
    floor: Floor
    known_n: float
    fall_pct: float
    interval: shrink.Interval | None
    explained_pct: float | None
    worse: list[str]


def errors(g: Judged) -> Errors:
    """Return what base and accepted model leave of data that they were not fitted to.

    The error is that of the simulator alone: what it is known to leave counts as well.
    """
    known, held = misfit.known(g.problem), g.search.held_out
    return Errors(
        known + held.residual(g.search.base), known + held.residual(g.accepted), fine_n(g, g.search.noise), g.search.sim.weight, known
    )


def of_other(g: Judged) -> float | None:
    """Return what another simulator's log is off by (RMS, in the unit of the output), None where none took the place of the base."""
    records, missed = {r.run_id: r for r in g.problem.records}, []
    for run in g.runs:
        r = records.get(run.run_id)
        if r is None or MISSED not in run.extra:
            continue
        used = np.isfinite(run.extra[MISSED])
        if g.fault is None:
            # what the recorder has spoilt is masked here as it is in the errors beside
            used &= np.interp(run.time_s, r.raw.time_s, r.raw_weight) > HALF
        missed.append(run.extra[MISSED][used])
    every = np.concatenate(missed) if missed else np.zeros(0)
    return float(np.sqrt(np.mean(every**2))) if len(every) else None


def sizes(g: Judged, e: Errors, code: NDArray[np.int64]) -> Sizes:
    """Return the gap in numbers; ``code`` is the phase of each sample, shape (samples,)."""
    sim = g.search.sim
    given = e.rms(sim.y + e.known - sim.predict(g.nominal, {}))
    base, with_effect = e.rms(e.base), e.rms(e.accepted)
    named, fault = g.accepted is not g.search.base, g.fault
    below = floor(g, e.fine_n)
    interval = shrink.shrinkage(sim, e.base, e.accepted, e.fine_n) if named else None
    percent = 100.0 * (1.0 - with_effect / base) if base > 0.0 else 0.0
    if fault is not None:
        # the spoilt samples are in both errors: before as they were read, after as explained
        base, with_effect, given = recorded.rms_n(sim, g.search.base.theta, g.nominal, fault)
        percent, interval = 100.0 * (1.0 - with_effect / max(base, 1e-300)), None
        if fault.id == "quantisation":
            below = Floor(unrounded_n(g), None, None)
    known = misfit.rms_n(g.problem)
    reducible = base - float(np.hypot(below.value_n, known))
    explained = 100.0 * (base - with_effect) / reducible if reducible > REDUCIBLE * base else None
    return Sizes(
        given_n=given,
        retuned_n=base,
        with_effect_n=with_effect,
        floor=below,
        known_n=known,
        fall_pct=percent,
        interval=interval,
        explained_pct=None if explained is None else float(np.clip(explained, -100.0, 100.0)),
        worse=shrink.worse_regions(sim, e.base, e.accepted, code) if named else [],
    )

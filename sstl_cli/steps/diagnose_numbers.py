"""Numbers of a document that have to be of the same readings: where the gap of a fault of the recorder lies, and how sure the floor is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.documents.diagnosis import Gap, Place
from sstl_cli.diagnosis import where
from sstl_cli.diagnosis.constants import DECIDES_NATS, HALF
from sstl_cli.diagnosis.evidence import strengths_charge
from sstl_cli.diagnosis.faults import squared_errors
from sstl_cli.diagnosis.fit import Fit, fit, held, normal_equations
from sstl_cli.diagnosis.found import NOTHING
from sstl_cli.diagnosis.whitening import Noise
from sstl_cli.steps.diagnose_given import Given

Array = NDArray[np.float64]
Codes = NDArray[np.int64]
# two-sided 95 % of a normal distribution
SIDES = 1.96


def recorded_shares(g: Given, code: Codes) -> list[Place]:
    """Return the share of the squared error of all raw readings by system, phase and configuration, largest first.

    What a fault of the recorder has spoilt is masked wherever models are compared, but it is in the error of the headline.

    Parameters
    ----------
    code : ndarray of int, shape (samples,)
        Phase of each sample at the analysis rate.
    """
    sim = g.search.sim
    sums: dict[tuple[str, str, str], list[float]] = {}
    parts = zip(g.problem.records, sim.predict_fine(g.search.base.theta, {}), sim.slices(), strict=True)
    for r, prediction, s in parts:
        expected, out, into = squared_errors(r, prediction)
        # readings of one sample have its phase
        phase = np.repeat(code[s], max(1, len(expected) // max(len(code[s]), 1)))[: len(expected)]
        phase = np.concatenate((phase, np.full(len(expected) - len(phase), phase[-1])))
        squared = np.bincount(phase, out + into, len(where.PHASES))
        count = np.bincount(phase, minlength=len(where.PHASES))
        config = sim.problem.configs[int(sim.config[s][0])]
        for k in np.flatnonzero(count):
            cell = sums.setdefault((r.system, where.PHASES[k], config), [0.0, 0.0])
            cell[0] += float(squared[k])
            cell[1] += float(count[k])
    total = max(sum(error for error, _ in sums.values()), 1e-300)
    rows = [
        Place(system=system, phase=phase, config_id=config, share_pct=100.0 * error / total, rmse_n=float(np.sqrt(error / n)))
        for (system, phase, config), (error, n) in sums.items()
    ]
    return sorted(rows, key=lambda row: -row.share_pct)


def before(g: Given, gap: Gap) -> dict[str, object]:
    """Return theta of a model that was accepted before, by bend that it has seen, and whether it has changed; nothing without one.

    It has where the odds of one that is fitted are beyond doubt (49 to 1, each bend charged for). Where nothing is named it has to explain at
    least half of the squared error of the model as given; beside effects that are named it is theirs: alone it would follow them.
    """
    had, f, sim = g.search.sim.accepted, g.accepted, g.search.sim
    if had is None:
        return {}
    seen = [i for i, (a, n) in enumerate(zip(had, g.nominal, strict=True)) if a == n]
    nats = _lost(g, f, had) if f.free else fit(sim, f.whiten, NOTHING, had, np.zeros(0), 0).cost - f.cost
    changed = bool(seen) and nats - strengths_charge(len(seen), 2.0 * max(nats, 0.0)) > DECIDES_NATS
    given, retuned = gap.rmse_base_n or 0.0, gap.rmse_retuned_n or 0.0
    if not f.free:
        changed = changed and retuned**2 <= (1.0 - HALF) * given**2
    of = {"theta_before": had, **({"theta_with_effect": f.theta} if f.free else {})}
    return {**{k: {g.problem.configs[i]: float(v[i]) for i in seen} for k, v in of.items()}, "theta_changed": changed}


def _lost(g: Given, f: Fit, theta: Array) -> float:
    """Return what a fit loses (nats, to second order) at another theta, its own parameters following."""
    a, _ = normal_equations(g.search.sim, f.whiten(f.jacobian), np.zeros(len(f.residual)))
    a += 1e-9 * np.diag(np.diag(a) + 1e-12)
    return held(a, np.arange(len(theta)), theta - f.theta)[0]


def floor_interval(noise: Noise, floor: Callable[[Noise], float]) -> tuple[float, float] | tuple[None, None]:
    """Return the ends of the 95 % interval of a noise floor (N), None where no spread of the noise is known.

    The errors of the estimated noise are told apart by sensor and system; each moves the floor by itself, by its own logarithm.

    Parameters
    ----------
    floor : callable
        The floor (N) of a noise.
    """
    middle = floor(noise)
    moved = [np.log(floor(raised) / middle) for raised in _raised(noise) if middle > 0.0]
    spread = float(np.sqrt(np.sum(np.square(moved))))
    # none known, or one of readings without any noise
    if not 0.0 < spread < np.inf:
        return None, None
    return float(middle * np.exp(-SIDES * spread)), float(middle * np.exp(SIDES * spread))


def below_floor(gap: Gap, effects: Sequence[str], unit: str) -> list[str]:
    """Return the note on an error that is smaller than the noise floor as it was estimated, if the named effects leave one.

    Examples
    --------
    >>> gap = Gap.model_construct(rmse_with_effect_n=0.0226, noise_floor_n=0.0235, noise_floor_low_n=0.0221, noise_floor_high_n=0.025)
    >>> below_floor(gap, ("zero_offset",), "N")
    ['the error with the effect is below the noise floor, which is known to 0.0221..0.025 N: nothing above noise is left']
    >>> below_floor(gap, (), "N")
    []
    """
    left, floor, low, high = gap.rmse_with_effect_n, gap.noise_floor_n, gap.noise_floor_low_n, gap.noise_floor_high_n
    if not effects or left is None or floor is None or left >= floor:
        return []
    known = "which is an estimate" if low is None else f"which is known to {low:.3g}..{high:.3g} {unit}"
    return [f"the error with the effect is below the noise floor, {known}: nothing above noise is left"]


def _raised(noise: Noise) -> list[Noise]:
    """Return the noise with one of its numbers after the other larger by its standard error."""
    found = []
    for system, spread in noise.spread.items():
        for key, by in spread.items():
            side, _, name = key.partition(".")
            factor = float(np.exp(by))
            if key == "smoother":
                found.append(replace(noise, smoother={**noise.smoother, system: factor * noise.smoother[system]}))
            elif side in ("input", "output") and name:
                sensors = getattr(noise, side)
                larger = replace(sensors[system], **{name: factor * getattr(sensors[system], name)})
                found.append(replace(noise, **{side: {**sensors, system: larger}}))
    return found

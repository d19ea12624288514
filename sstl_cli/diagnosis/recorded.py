"""Errors over all raw readings: what a fault of the recorder has spoilt is masked wherever models are compared, but it is in these."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.documents.diagnosis import Place
from sstl_cli.diagnosis.faults import RecorderEffect, squared_errors
from sstl_cli.diagnosis.readings import gaps
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.where import PHASES

Array = NDArray[np.float64]


def shares(sim: Simulator, theta: Array, code: NDArray[np.int64]) -> list[Place]:
    """Return the share of the squared error of all raw readings by system, phase and configuration, largest first.

    Parameters
    ----------
    theta : ndarray, shape (configurations,)
        Of the base, in rad.
    code : ndarray of int, shape (samples,)
        Phase of each sample at the analysis rate.
    """
    sums: dict[tuple[str, str, str], list[float]] = {}
    for r, prediction, s in zip(sim.problem.records, sim.predict_fine(theta, {}), sim.slices(), strict=True):
        expected, out, into = squared_errors(r, prediction)
        # readings of one sample have its phase
        phase = np.repeat(code[s], max(1, len(expected) // max(len(code[s]), 1)))[: len(expected)]
        phase = np.concatenate((phase, np.full(len(expected) - len(phase), phase[-1])))
        squared = np.bincount(phase, out + into, len(PHASES))
        count = np.bincount(phase, minlength=len(PHASES))
        config = sim.problem.configs[int(sim.config[s][0])]
        for k in np.flatnonzero(count):
            cell = sums.setdefault((r.system, PHASES[k], config), [0.0, 0.0])
            cell[0] += float(squared[k])
            cell[1] += float(count[k])
    total = max(sum(error for error, _ in sums.values()), 1e-300)
    rows = [
        Place(system=system, phase=phase, config_id=config, share_pct=100.0 * error / total, rmse_n=float(np.sqrt(error / n)))
        for (system, phase, config), (error, n) in sums.items()
    ]
    return sorted(rows, key=lambda row: -row.share_pct)


def rms_n(sim: Simulator, theta: Array, nominal: Array, fault: RecorderEffect) -> tuple[float, float, float]:
    """Return RMSE (N) before and after a fault of the recorder is taken out, and as given, all over all raw samples.

    Readings of the input that were spoilt count as well: a fault is named for those of both sensors.

    Parameters
    ----------
    theta, nominal : ndarray, shape (configurations,)
        Of the base, re-tuned and as given, in rad.
    """

    def power(theta: Array) -> tuple[float, int]:
        total, count = 0.0, 0
        for r, prediction in zip(sim.problem.records, sim.predict_fine(theta, {}), strict=True):
            expected, out, into = squared_errors(r, prediction)
            total += float(out.sum() + into.sum())
            count += int(np.count_nonzero(gaps(r.raw)[: len(expected)] == 0))
        return total, max(count, 1)

    total, count = power(theta)
    left = max(total - fault.removed_n2, 0.0)
    return float(np.sqrt(total / count)), float(np.sqrt(left / count)), float(np.sqrt(power(nominal)[0] / count))

"""What pulled beside a tendon while it was recorded: the tension of its neighbours, where that is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import COVERED

# the extra channel that holds it
NEIGHBOUR = "neighbour_n"


def with_neighbours(run: Run, runs: Sequence[Run]) -> Run:
    """Return a run with the summed input tension (N) of the other tendons as ``extra['neighbour_n']``.

    The other tendons' runs must share configuration and trajectory, and cover the run's time; a tendon with none or
    with several such runs leaves the run as it is: what pulled beside it is not known.
    """
    if run.config_id is None:
        return run
    others = {r.tendon or "" for r in runs if r.system == "act"} - {run.tendon or ""}
    total = np.zeros(len(run))
    for name in sorted(others):
        beside = [
            r
            for r in runs
            if r.system == "act"
            and (r.tendon or "") == name
            and r.config_id == run.config_id
            and r.trajectory == run.trajectory
            and _covers(r, run)
        ]
        if len(beside) != 1:
            return run
        good = np.isfinite(beside[0].tension_in_n) & np.isfinite(beside[0].time_s)
        total += np.interp(run.time_s, beside[0].time_s[good], beside[0].tension_in_n[good])
    return replace(run, extra={**run.extra, NEIGHBOUR: total})


def _covers(other: Run, run: Run) -> bool:
    if len(other) < 2 or len(run) < 2:
        return False
    overlap = min(other.time_s[-1], run.time_s[-1]) - max(other.time_s[0], run.time_s[0])
    return bool(overlap >= COVERED * (run.time_s[-1] - run.time_s[0]))

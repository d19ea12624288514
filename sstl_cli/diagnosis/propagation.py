"""Does what is pulled at one end arrive at the other? Where it never does, no effect can show."""

from __future__ import annotations

import numpy as np

from sstl_cli.diagnosis.constants import LEFT_STEPS, SHORTEST_LEFT, SMOOTHED
from sstl_cli.diagnosis.records import Problem


def propagates(problem: Problem) -> bool:
    """Return whether the output of any run moves by clearly more than its noise."""
    for r in problem.records:
        if len(r) > SHORTEST_LEFT:
            smooth = np.convolve(r.y, np.full(SMOOTHED, 1.0 / SMOOTHED), mode="valid")
            if np.ptp(smooth) > LEFT_STEPS * max(float(np.median(np.abs(np.diff(r.y)))), 1e-12):
                return True
    return False

"""How well friction of one run compares with that of another of the same rig."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence

# runs that must tell their gain, and the least scatter of it that is believed
FEW, LEAST = 4, 0.004


def friction_error(runs: Sequence[Evidence]) -> float:
    """Return the error of n theta of one of these runs against the others.

    Gain and friction are the half sum and the half difference of the same two logarithms of slopes. The gain is the same
    in all runs of one rig, so that its scatter tells the error of the friction, however careful the runs' own errors are.
    """
    own = float(np.median([e.slopes.friction_se for e in runs]))
    gains = np.log([e.slopes.gain for e in runs])
    if len(gains) < FEW:
        return own
    return min(own, max(LEAST, 1.4826 * float(np.median(np.abs(gains - np.median(gains))))))

"""How well friction of one run compares with that of another of the same rig."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sstl_cli.identification.filtering import spread
from sstl_cli.identification.gate.evidence import Evidence

# runs that must tell their gain, the least scatter of it that is believed, and scatters at which a run stands apart
FEW, LEAST, APART = 4, 0.004, 3.0


def friction_errors(runs: Sequence[Evidence]) -> dict[str, float]:
    """Return the error of n theta of each of these runs against the others, by run.

    Gain and friction are the half sum and the half difference of the same two logarithms of slopes. The gain is the same
    in all runs of one rig, so that its scatter tells the error of the friction, however careful the runs' own errors are.
    A run whose gain stands apart has lines that are not those of friction, and is off by as much.
    """
    own = np.array([e.slopes.friction_se for e in runs])
    gains = np.log([e.slopes.gain for e in runs])
    if len(gains) >= FEW:
        away = np.abs(gains - np.median(gains))
        scatter = max(LEAST, spread(away))
        own = np.where(away > APART * scatter, np.maximum(own, away), np.minimum(own, scatter))
    return {e.run_id: float(v) for e, v in zip(runs, own, strict=True)}

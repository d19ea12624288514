"""An output channel behind an analogue filter: a lag of first order."""

import numpy as np
from numba import njit

from sstl_cli.physics.bristle.effect import Effect, FloatArray, Reading, Values
from sstl_cli.physics.given import Bounds


@njit(cache=True)
def relax(time: FloatArray, signal: FloatArray, tau: float) -> FloatArray:
    """First-order lag of a signal that holds its mean between two samples."""
    seen = np.empty_like(signal)
    seen[0] = signal[0]
    for n in range(1, signal.size):
        keep = np.exp((time[n - 1] - time[n]) / tau)
        seen[n] = keep * seen[n - 1] + (1.0 - keep) * 0.5 * (signal[n] + signal[n - 1])
    return seen


def _sample(seen: Reading, v: Values) -> None:
    tau = v[f"tau_{seen.system}_s"]
    if tau > 0.0:
        seen.t_out = relax(seen.time, seen.t_out, tau)


EFFECT = Effect({f"tau_{system}_s": Bounds(0.0, 0.0, 0.32) for system in ("act", "sstl")}, sample=_sample)

"""An output channel behind an analogue filter of first order."""

import numpy as np
from numba import njit

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, FloatArray, Reading, Values


@njit(cache=True)
def first_order(time: FloatArray, signal: FloatArray, tau: float) -> FloatArray:
    """First-order low-pass of a signal that runs straight between samples: exact for ramps, any time base."""
    out = np.empty_like(signal)
    out[0] = signal[0]
    for n in range(1, signal.size):
        dt = time[n] - time[n - 1]
        decay = np.exp(-dt / tau)
        slope = (signal[n] - signal[n - 1]) / dt
        settled = signal[n] - slope * tau
        out[n] = settled + (out[n - 1] - signal[n - 1] + slope * tau) * decay
    return out


def _sense(seen: Reading, v: Values) -> None:
    tau = v[f"tau_{seen.system}_s"]
    if tau > 0.0:
        seen.t_out = first_order(seen.time, seen.t_out, tau)


EFFECT = Effect({f"tau_{system}_s": Bounds(0.0, 0.0, 0.32) for system in ("act", "sstl")}, order=70, sense=_sense)

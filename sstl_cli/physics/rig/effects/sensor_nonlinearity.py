"""Sensors that read on a parabola, and an output element that comes round only after a play."""

import numpy as np
from numba import njit

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, FloatArray, Reading, Values

FULL_SCALE_N = 50.0


@njit(cache=True)
def sensor_play(signal: FloatArray, half_width: float) -> FloatArray:
    """Hysteresis of a sensor element: the reading stays while the tension moves within +-half_width of it."""
    out = np.empty_like(signal)
    out[0] = signal[0]
    for n in range(1, signal.size):
        out[n] = min(max(out[n - 1], signal[n] - half_width), signal[n] + half_width)
    return out


def _sense(seen: Reading, v: Values) -> None:
    seen.t_in = seen.t_in + v["a_in"] * seen.t_in * (1.0 - seen.t_in / FULL_SCALE_N)
    seen.t_out = seen.t_out + v["a_out"] * seen.t_out * (1.0 - seen.t_out / FULL_SCALE_N)
    if v["h_n"] > 0.0:
        seen.t_out = sensor_play(seen.t_out, v["h_n"])


EFFECT = Effect({"a_in": Bounds(0.0, -0.02, 0.02), "a_out": Bounds(0.0, -0.02, 0.02), "h_n": Bounds(0.0, 0.0, 0.1)}, order=50, sense=_sense)

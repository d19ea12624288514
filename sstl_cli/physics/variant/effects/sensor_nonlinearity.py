"""Sensors whose characteristic is bent, and an output element with hysteresis."""

import numpy as np
from numba import njit

from sstl_cli.physics.variant.effect import Effect, Reading, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

FULL_SCALE_N = 50.0
LAWS = (
    Law("cubic", "T + 2 a T (1 - (T/50)^2); three plays", "load-cell calibration polynomial, ISO 376", 0.5, 1.5),
    Law("piecewise", "slopes 1 + a and 1 - a/3 about a knee; three plays", "spring that comes to rest on a stop, textbook", 6.0, 15.0),
)


@njit(cache=True)
def held_play(signal: Array, half_width: float) -> Array:
    """Return a signal behind a play of +-half_width (N)."""
    out = signal.copy()
    for n in range(1, signal.size):
        out[n] = min(max(out[n - 1], signal[n] - half_width), signal[n] + half_width)
    return out


def _curved(t: Array, a: float, law: Chosen) -> Array:
    if a == 0.0:
        return t
    if law.id == "cubic":
        return t + 2.0 * a * law.shape * t * (1.0 - (t / FULL_SCALE_N) ** 2)
    return t + a * (np.minimum(t, law.shape) - np.maximum(t - law.shape, 0.0) / 3.0)


def _sense(seen: Reading, v: Values, law: Chosen) -> None:
    seen.t_in, seen.t_out = _curved(seen.t_in, v["a_in"], law), _curved(seen.t_out, v["a_out"], law)
    if v["h_n"] > 0.0:
        # Prandtl-Ishlinskii: three plays instead of one, as wide on the mean
        plays = (held_play(seen.t_out, w * v["h_n"]) for w in (0.4, 1.0, 1.6))
        seen.t_out = sum(plays, np.zeros(seen.t_out.size)) / 3.0


EFFECT = Effect({"a_in": wide(0.0, -0.02, 0.02), "a_out": wide(0.0, -0.02, 0.02), "h_n": wide(0.0, 0.0, 0.1)}, LAWS, order=50, sense=_sense)

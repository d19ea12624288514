"""Sensors whose gain falls with the tension, and an output element that sticks."""

from numba import njit

from sstl_cli.physics.bristle.effect import Effect, FloatArray, Reading, Values
from sstl_cli.physics.given import Bounds

FULL_SCALE_N = 50.0


@njit(cache=True)
def sticky(signal: FloatArray, half: float) -> FloatArray:
    """Reading of an element that moves only when it is pushed by more than `half`."""
    seen = signal.copy()
    for n in range(1, signal.size):
        off = signal[n] - seen[n - 1]
        seen[n] = seen[n - 1]
        if abs(off) > half:
            seen[n] += off - half if off > 0.0 else off + half
    return seen


def _sense(seen: Reading, v: Values) -> None:
    seen.t_in = seen.t_in * (1.0 + v["a_in"] * (1.0 - seen.t_in / FULL_SCALE_N))
    seen.t_out = seen.t_out * (1.0 + v["a_out"] * (1.0 - seen.t_out / FULL_SCALE_N))
    if v["h_n"] > 0.0:
        seen.t_out = sticky(seen.t_out, v["h_n"])


EFFECT = Effect({"a_in": Bounds(0.0, -0.02, 0.02), "a_out": Bounds(0.0, -0.02, 0.02), "h_n": Bounds(0.0, 0.0, 0.1)}, order=50, sense=_sense)

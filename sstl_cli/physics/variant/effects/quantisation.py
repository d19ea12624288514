"""Readings in steps of the converter, cut off or sent anew once they have moved by one."""

import numpy as np
from numba import njit

from sstl_cli.physics.variant.effect import Effect, Reading, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

LAWS = (
    Law("truncate", "q floor(T/q)", "converter that truncates, textbook"),
    Law("deadband", "a new value once T has moved by q", "send-on-delta: Miskowicz, Sensors 6 (2006) 49"),
)


@njit(cache=True)
def deadband(signal: Array, step: float) -> Array:
    """Return a signal that is sent anew only once it has moved by a step (N)."""
    out = signal.copy()
    for n in range(1, signal.size):
        out[n] = signal[n] if abs(signal[n] - out[n - 1]) >= step else out[n - 1]
    return out


def stepped(signal: Array, step: float, law: Chosen) -> Array:
    """Return a signal in steps (N), the signal itself where they are 0."""
    if step <= 0.0:
        return signal
    return np.asarray(step * np.floor(signal / step) if law.id == "truncate" else deadband(signal, step))


def _store(seen: Reading, v: Values, law: Chosen) -> None:
    seen.t_in, seen.t_out = stepped(seen.t_in, v["q_in_n"], law), stepped(seen.t_out, v["q_out_n"], law)


EFFECT = Effect({f"q_{side}_n": wide(0.0, 0.0, 0.5) for side in ("in", "out")}, LAWS, order=85, store=_store)

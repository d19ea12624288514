"""Tensions beyond the full scale, which are compressed or wrap around."""

import numpy as np

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.variant.effect import Effect, Reading, Values
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

UNLIMITED_N = 1000.0
LAWS = (
    Law("soft_knee", "T - w ln(1 + exp((T - Tmax)/w)), w = s Tmax", "amplifier compression, textbook", 0.01, 0.04),
    Law("wrap", "T mod Tmax", "overflow of an unsigned word, textbook"),
)


def limited(signal: Array, ceiling: float, law: Chosen) -> Array:
    """Return what a converter with this full scale (N) makes of a signal."""
    if ceiling >= UNLIMITED_N:
        return signal
    if law.id == "soft_knee":
        width = law.shape * ceiling
        return np.asarray(signal - width * np.logaddexp(0.0, (signal - ceiling) / width))
    return np.where(signal >= ceiling, np.mod(signal, ceiling), signal)


def _store(seen: Reading, v: Values, law: Chosen) -> None:
    seen.t_in, seen.t_out = limited(seen.t_in, v["t_max_in_n"], law), limited(seen.t_out, v["t_max_out_n"], law)


EFFECT = Effect({f"t_max_{side}_n": Bounds(1000.0, 0.5, 1000.0) for side in ("in", "out")}, LAWS, order=80, store=_store)

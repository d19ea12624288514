"""Rounding to multiples of the converter's step."""

import numpy as np

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, FloatArray, Reading, Values


def rounded(signal: FloatArray, step: float) -> FloatArray:
    """Multiples of `step` (N) nearest to a signal, the signal itself where that is 0."""
    return np.round(signal / step) * step if step > 0.0 else signal


def _store(seen: Reading, v: Values) -> None:
    seen.t_in, seen.t_out = rounded(seen.t_in, v["q_in_n"]), rounded(seen.t_out, v["q_out_n"])


EFFECT = Effect({f"q_{side}_n": Bounds(0.0, 0.0, 0.5) for side in ("in", "out")}, order=85, store=_store)

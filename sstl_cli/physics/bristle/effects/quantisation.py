"""Rounding to multiples of the converter's step."""

import numpy as np

from sstl_cli.physics.bristle.effect import Effect, Reading, Values
from sstl_cli.physics.given import Bounds


def _store(seen: Reading, v: Values) -> None:
    if v["q_in_n"] > 0.0:
        seen.t_in = v["q_in_n"] * np.rint(seen.t_in / v["q_in_n"])
    if v["q_out_n"] > 0.0:
        seen.t_out = v["q_out_n"] * np.rint(seen.t_out / v["q_out_n"])


EFFECT = Effect({f"q_{side}_n": Bounds(0.0, 0.0, 0.5) for side in ("in", "out")}, order=85, store=_store)

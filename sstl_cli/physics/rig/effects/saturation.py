"""Nothing above the full scale of the converter."""

import numpy as np

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Reading, Values


def _store(seen: Reading, v: Values) -> None:
    seen.t_in, seen.t_out = np.minimum(seen.t_in, v["t_max_in_n"]), np.minimum(seen.t_out, v["t_max_out_n"])


EFFECT = Effect({f"t_max_{side}_n": Bounds(1000.0, 1.0, 1000.0) for side in ("in", "out")}, order=80, store=_store)

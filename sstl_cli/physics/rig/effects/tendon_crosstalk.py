"""Other tendons of the tube, whose tension opens or closes the bend."""

import numpy as np

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    per_n, beside = v["c_bend_per_n"], rig.run.neighbour_n
    if per_n != 0.0 and beside is not None:
        # A bend pulled straight and beyond would rub on the other wall: it never quite vanishes.
        rig.swell = np.clip(1.0 + per_n * beside, 0.05, None)


EFFECT = Effect({"c_bend_per_n": Bounds(0.0, -0.01, 0.02)}, build=_build)

"""Neighbours that bend the tube by a share a newton, less and less as it stiffens."""

import numpy as np

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    if made.run.neighbour_n is not None:
        made.swell = np.exp(2.0 * np.tanh(0.5 * v["c_bend_per_n"] * made.run.neighbour_n))


EFFECT = Effect({"c_bend_per_n": Bounds(0.0, -0.01, 0.02)}, build=_build)

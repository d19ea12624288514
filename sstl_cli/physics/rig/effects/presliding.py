"""Contacts that give elastically before they slide, each over a distance of its own."""

import numpy as np

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values

GOLDEN = 0.6180339887498949


def _build(rig: Parts, v: Values) -> None:
    # Break-away distances cover breakaway * (1 +- spread) evenly, in an order without trend along the tendon.
    place = 2.0 * np.mod(GOLDEN * (np.arange(rig.sheathed.size) + 0.5), 1.0) - 1.0
    given = v["breakaway_mm"] * (1.0 + v["spread"] * place)
    rig.chain.breakaway[rig.sheathed] += given[rig.sheathed]


EFFECT = Effect({"breakaway_mm": Bounds(0.0, 0.0, 1.5), "spread": Bounds(0.5, 0.0, 1.0)}, build=_build)

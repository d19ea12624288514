"""Longer bristles, each node's of a length of its own."""

import numpy as np

from sstl_cli.physics.bristle.effect import Effect, FloatArray, Parts, Values
from sstl_cli.physics.given import Bounds


def scattered(size: int) -> FloatArray:
    """Numbers evenly in -1..1 in an order without trend (van der Corput, base 2)."""
    place = np.zeros(size)
    index, unit = np.arange(1, size + 1), 0.5
    while np.any(index):
        place += unit * (index % 2)
        index, unit = index // 2, 0.5 * unit
    return 2.0 * place - 1.0


def _build(made: Parts, v: Values) -> None:
    given = v["breakaway_mm"] * (1.0 + v["spread"] * scattered(made.sheathed.size))
    made.contact.delta[made.sheathed] += given[made.sheathed]


EFFECT = Effect({"breakaway_mm": Bounds(0.0, 0.0, 1.5), "spread": Bounds(0.5, 0.0, 1.0)}, build=_build)

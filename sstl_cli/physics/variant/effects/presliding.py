"""Contacts that give before they slide, each over a distance of its own."""

import numpy as np

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("dahl", "dF/du = (1 - F/Fc sgn v) 2 Fc/b", "Dahl, TOR-158(3107-18), Aerospace Corp. (1968)"),
    Law("bouc_wen", "dF = 2 Fc/b (du - (|du| F + du |F|) / (2 Fc))", "Wen, J. Eng. Mech. Div. 102 (1976) 249, n = 1, beta = gamma"),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rate = made.rate._replace(soft=v["breakaway_mm"], soft_code=law.code)
    # break-away distances cover z (1 +- spread) evenly over the rubbing stations, in the order of van der Corput
    rubbing = made.line.angle + made.line.weight > 0.0
    place = np.array([int(f"{i:010b}"[::-1], 2) / 512.0 - 1.0 for i in np.cumsum(rubbing).tolist()])
    # half of it is the distance of an exponential that lags as much as a straight rise over all of it
    mean = 0.5 * v["breakaway_mm"]
    made.line.breakaway[:] = np.where(rubbing, np.maximum(mean * (1.0 + v["spread"] * place), 0.02 * mean), 0.0)


EFFECT = Effect({"breakaway_mm": wide(0.0, 0.0, 1.5), "spread": Bounds(0.5, 0.0, 1.0)}, LAWS, build=_build)

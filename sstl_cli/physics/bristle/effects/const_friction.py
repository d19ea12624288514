"""Friction that does not depend on tension, spread over the nodes of the sheath."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.contact.bias[made.sheathed] += v["w_l_n"] / made.spec.nodes


EFFECT = Effect({"w_l_n": Bounds(0.0, 0.0, 0.5)}, build=_build)

"""Friction that does not depend on tension, spread over the sheath."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.contact.weight_n[rig.sheathed] += v["w_l_n"] / rig.spec.nodes


EFFECT = Effect({"w_l_n": Bounds(0.0, 0.0, 0.5)}, build=_build)

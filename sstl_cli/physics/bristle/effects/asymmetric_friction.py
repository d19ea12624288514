"""Capstan exponents that differ between pulling and releasing."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.contact.theta_pull[made.sheathed] *= 1.0 + v["a"]
    made.contact.theta_release[made.sheathed] *= 1.0 - v["a"]


EFFECT = Effect({"a": Bounds(0.0, -0.2, 0.2)}, build=_build)

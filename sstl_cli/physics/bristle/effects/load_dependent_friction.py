"""Friction of a Hertz contact with adhesion: a contact area that goes with a power of the load."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.law = made.law._replace(alpha=v["alpha"])


EFFECT = Effect({"alpha": Bounds(0.0, -0.1, 0.33)}, build=_build)

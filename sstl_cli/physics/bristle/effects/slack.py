"""Free length at the drive, which a tendon without tension takes up."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.setting = made.setting._replace(gap=v["gap_mm"])


EFFECT = Effect({"gap_mm": Bounds(0.0, 0.0, 5.0)}, build=_build)

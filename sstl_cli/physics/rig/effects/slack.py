"""Free length at the drive, which a tendon without tension takes up."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.setting = rig.setting._replace(gap=v["gap_mm"])


EFFECT = Effect({"gap_mm": Bounds(0.0, 0.0, 5.0)}, build=_build)

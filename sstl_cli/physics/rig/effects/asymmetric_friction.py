"""A friction coefficient that differs between pulling and releasing."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.contact_law = rig.contact_law._replace(asymmetry=v["a"])


EFFECT = Effect({"a": Bounds(0.0, -0.2, 0.2)}, build=_build)

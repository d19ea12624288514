"""A friction coefficient that goes with a power of the local tension."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.tension_law = rig.tension_law._replace(alpha=v["alpha"])


EFFECT = Effect({"alpha": Bounds(0.0, -0.1, 0.33)}, build=_build)

"""A tendon that creeps under load: two Kelvin elements."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds

# The two elements have half the strength each, one so much faster, one so much slower.
CREEP_SPREAD = 3.0


def _build(made: Parts, v: Values) -> None:
    times = (v["tau_s"] / CREEP_SPREAD, v["tau_s"] * CREEP_SPREAD)
    made.setting = made.setting._replace(creep_fraction=v["fraction"], creep_s=times)


EFFECT = Effect({"fraction": Bounds(0.0, 0.0, 0.3), "tau_s": Bounds(10.0, 1.0, 100.0)}, build=_build)

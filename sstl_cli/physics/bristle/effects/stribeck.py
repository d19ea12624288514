"""More friction at low speed, by the age of the film under the contacts."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.law = made.law._replace(stribeck_ratio=v["ratio"], stribeck_speed=v["v_s_mm_s"])


EFFECT = Effect({"ratio": Bounds(1.0, 1.0, 1.5), "v_s_mm_s": Bounds(1.0, 0.1, 10.0)}, build=_build)

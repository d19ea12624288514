"""More friction at low speed: a bell of the sliding speed that the contacts remember."""

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.effect import Effect, Parts, Values


def _build(rig: Parts, v: Values) -> None:
    rig.contact_law = rig.contact_law._replace(stribeck_ratio=v["ratio"], stribeck_speed=v["v_s_mm_s"])


EFFECT = Effect({"ratio": Bounds(1.0, 1.0, 1.5), "v_s_mm_s": Bounds(1.0, 0.1, 10.0)}, build=_build)

"""Static friction above kinetic, half of which is back after a rest that the speed scale sets."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.law = made.law._replace(stick_ratio=v["ratio"], stick_s=made.spec.healing_mm / v["v_c_mm_s"])


EFFECT = Effect({"ratio": Bounds(1.0, 1.0, 1.5), "v_c_mm_s": Bounds(1.0, 0.1, 10.0)}, build=_build)

"""Friction that grows with a power of the time of contact."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.law = made.law._replace(dwell_b=v["b"], dwell_t0=v["t0_s"])


EFFECT = Effect({"b": Bounds(0.0, 0.0, 0.05), "t0_s": Bounds(1.0, 0.1, 10.0)}, build=_build)

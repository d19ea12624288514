"""Drag where the tube is bent, in proportion to the sliding speed."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    made.contact.drag[:] += v["c_l_n_s_per_mm"] * made.weights


EFFECT = Effect({"c_l_n_s_per_mm": Bounds(0.0, 0.0, 0.05)}, build=_build)

"""Free length at the drive, which a tendon takes up as it comes under tension."""

import numpy as np

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

LAWS = (
    Law("catenary", "gap T^2 / (T^2 + Tc^2)", "Irvine, Cable Structures (1981): excess length by 1/T^2", 0.2, 1.0),
    Law("toe", "gap (1 - exp(-T/Tc))", "toe of a rope: Feyrer, Wire Ropes (2015)", 0.2, 1.0),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    def taken(tension: Array) -> Array:
        if law.id == "catenary":
            return v["gap_mm"] * (tension**2 / (tension**2 + law.shape**2))
        return v["gap_mm"] * -np.expm1(-tension / law.shape)

    made.travels.append(taken)


EFFECT = Effect({"gap_mm": wide(0.0, 0.0, 5.0)}, LAWS, build=_build)

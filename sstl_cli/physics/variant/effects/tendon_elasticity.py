"""A tendon of another stiffness than the data sheet says, whose wires settle or slip."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("stiffening", "e = C (T + s Ta (1 - exp(-T/Ta))), Ta = 4 N", "Feyrer, Wire Ropes (2015): modulus that rises with stress", 0.3, 0.8),
    Law(
        "hysteretic", "e = C (T - s z), z = stop of T, +-2 N", "Raoof, Hobbs, J. Eng. Mech. 114 (1988) 1166: slip between wires", 0.15, 0.4
    ),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    per_kn = v["compliance_per_kn"]
    made.spring = made.spring._replace(rope=per_kn, rope_code=law.code, rope_shape=law.shape)
    if per_kn > 0.0:
        made.soften(made.spec.length_mm * (per_kn / 1000.0))


EFFECT = Effect({"compliance_per_kn": wide(0.0, 0.0, 0.33)}, LAWS, order=10, build=_build)

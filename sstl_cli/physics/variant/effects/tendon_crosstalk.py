"""Other tendons of the tube, which press on this one or bend the tube."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("pressing", "dT = -zeta mu kappa (T + c T_n 10 N) ds", "tendons that lie on one another, textbook normal force"),
    Law("stiffening", "theta (1 + c T_n / (1 + |c| T_n))", "large deflection of the tube, Howell, Compliant Mechanisms (2001)"),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rate = made.rate._replace(beside=v["c_bend_per_n"], beside_code=law.code)


EFFECT = Effect({"c_bend_per_n": wide(0.0, -0.01, 0.02)}, LAWS, build=_build)

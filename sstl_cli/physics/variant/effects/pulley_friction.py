"""The pulley between the two passes: a share of the tension, by direction, and a constant."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("rolling", "m T (T/10)^(1/3); f0 (1 - exp(-T/2))", "Greenwood, Minshall, Tabor, Proc. R. Soc. A 259 (1961) 480", 1 / 3, 1 / 3),
    Law("bearing", "m T (T/10)^y; f0 max(1, v/v0)^(2/3)", "Palmgren, Ball and Roller Bearing Engineering (1959): M1 and M0", 0.1, 0.5),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rub = made.rub._replace(
        pulley_pull=v["m_p"], pulley_release=v["m_r"], pulley_n=v["f0_n"], pulley_code=law.code, pulley_power=law.shape
    )


EFFECT = Effect({"m_p": wide(0.0, 0.0, 0.25), "m_r": wide(0.0, 0.0, 0.25), "f0_n": wide(0.0, 0.0, 2.0)}, LAWS, build=_build)

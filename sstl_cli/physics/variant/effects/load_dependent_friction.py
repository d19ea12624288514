"""A friction coefficient that falls with the local tension."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("hertz", "mu = mu0 (1 - 3a + 3a (T/10)^(-1/3))", "Briscoe, Tabor, Wear 34 (1975) 29: shear strength on a Hertz contact"),
    Law("step", "mu = mu0 (1 + 0.69 a tanh((Ts - T) / 1.5))", "Catalogue: the tendon changes sides in the sheath", 6.0, 14.0),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rub = made.rub._replace(load=v["alpha"], load_code=law.code, load_shape=law.shape)


EFFECT = Effect({"alpha": wide(0.0, -0.1, 0.33)}, LAWS, build=_build)

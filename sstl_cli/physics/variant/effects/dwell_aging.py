"""Static friction that grows with the rest."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, positive, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("power", "1 + b ((1 + t/t0)^n - 1) / n", "Rabinowicz, Proc. Phys. Soc. 71 (1958) 668", 0.1, 0.3),
    Law("kato", "1 + L b (1 - exp(-(t/t0)^m / L)), L = 3", "Kato, Sato, Matsubayashi (1972)", 0.4, 0.7),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rate = made.rate._replace(dwell=v["b"], dwell_s=v["t0_s"], dwell_code=law.code, dwell_shape=law.shape)


EFFECT = Effect({"b": wide(0.0, 0.0, 0.05), "t0_s": positive(1.0, 0.1, 10.0)}, LAWS, build=_build)

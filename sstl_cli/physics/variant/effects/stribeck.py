"""More friction at low speed, by the speed that the contacts remember."""

from sstl_cli.physics.variant.effect import Effect, Parts, Values, positive, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("hess_soom", "1 + (r - 1) / (1 + (v/vs)^2)", "Hess, Soom, J. Tribol. 112 (1990) 147"),
    Law(
        "exponent",
        "1 + (r - 1) exp(-(v/vs)^n)",
        "Tustin, J. IEE 94 (1947) (n = 1); Bo, Pavelescu, Wear 82 (1982) 277 (n = 0.5-1)",
        0.5,
        1.2,
    ),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rate = made.rate._replace(speed=v["ratio"] - 1.0, speed_mm_s=v["v_s_mm_s"], speed_code=law.code, speed_shape=law.shape)


EFFECT = Effect({"ratio": wide(1.0, 1.0, 1.5), "v_s_mm_s": positive(1.0, 0.1, 10.0)}, LAWS, build=_build)

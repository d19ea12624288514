"""A sheath that bends further with the local tension, and shortens with that at its begin."""

import numpy as np

from sstl_cli.physics.variant.effect import Effect, Parts, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array

LAWS = (
    Law("beam_column", "Phi = Phi0 / (1 - c T); u = k T (1 + T/50)", "Timoshenko, Gere, Theory of Elastic Stability (1961) 1.11"),
    Law("stop", "Phi = Phi0 (1 + c Ts (1 - exp(-T/Ts)))", "coils that close, textbook", 8.0, 30.0),
)


def _build(made: Parts, v: Values, law: Chosen) -> None:
    made.rub = made.rub._replace(sheath=v["c_t_per_n"], sheath_code=law.code, sheath_shape=law.shape)

    def shortened(tension: Array) -> Array:
        if law.id == "stop":
            return np.asarray(v["k_sh_mm_per_n"] * law.shape * -np.expm1(-tension / law.shape))
        return v["k_sh_mm_per_n"] * tension * (1.0 + tension / 50.0)

    made.travels.append(shortened)


EFFECT = Effect({"c_t_per_n": wide(0.0, 0.0, 0.01), "k_sh_mm_per_n": wide(0.0, 0.0, 0.2)}, LAWS, build=_build)

"""A sheath that bends further under load, or straightens: friction grows faster, or more slowly, than the tension."""

import numpy as np

from sstl_cli.physics.effect import FRICTION_LAW, Array, Effect, Law, Parameter, Position, Values

# e-folds by which a tube that buckles yields at most
STEEPEST = 30.0


def _law(law: Law, v: Values) -> None:
    c_t, q = v["c_t_per_n"], v["closing_per_n"]
    if c_t != 0.0:

        def factor(tension: Array) -> Array:
            # a fit may ask for the absurd; it must only stay a number
            grown = tension if q == 0.0 else -np.expm1(np.minimum(-q * tension, STEEPEST)) / q
            return np.asarray(np.maximum(1.0 + c_t * grown, 0.0))

        law.factors.append(factor)


def _position(position: Position, v: Values) -> None:
    position.sheath_mm_per_n += v["k_sh_mm_per_n"]


EFFECT = Effect(
    id="sheath_compliance",
    title="Sheath that yields under load",
    stage=FRICTION_LAW,
    equation="Phi = Phi0 (1 + c_T (1 - exp(-q T)) / q), for q = 0 Phi0 (1 + c_T T); u += T k_sh",
    source="Catalogue entry [G]",
    parameters=(
        Parameter(
            "c_t_per_n",
            "1/N",
            0.0,
            -0.01,
            0.01,
            "growth of the bending angle with tension; below 0 the tube straightens",
            limits=(-0.05, 0.1),
        ),
        # coils that close stop it (q > 0), a tube that buckles yields ever more (q < 0)
        Parameter("closing_per_n", "1/N", 0.0, -0.02, 0.15, "how soon its growth ends", shape=True, limits=(-0.5, 0.5)),
        Parameter("k_sh_mm_per_n", "mm/N", 0.0, 0.0, 0.2, "shortening of the sheath under load (position only)"),
    ),
    excitation="A wide span of tension; position for the shortening.",
    look_alikes=("load_dependent_friction",),
    law=_law,
    position=_position,
)

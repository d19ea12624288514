"""A sheath that bends further under load: friction grows faster than the tension."""

from sstl_cli.physics.effect import FRICTION_LAW, Array, Effect, Law, Parameter, Position, Values


def _law(law: Law, v: Values) -> None:
    c_t = v["c_t_per_n"]
    if c_t != 0.0:

        def factor(tension: Array) -> Array:
            return 1.0 + c_t * tension

        law.factors.append(factor)


def _position(position: Position, v: Values) -> None:
    position.sheath_mm_per_n += v["k_sh_mm_per_n"]


EFFECT = Effect(
    id="sheath_compliance",
    title="Sheath that yields under load",
    stage=FRICTION_LAW,
    equation="Phi = Phi0 (1 + c_T T), u += T k_sh",
    source="Catalogue entry [G]",
    parameters=(
        Parameter("c_t_per_n", "1/N", 0.0, 0.0, 0.01, "growth of the bending angle with tension"),
        Parameter("k_sh_mm_per_n", "mm/N", 0.0, 0.0, 0.2, "shortening of the sheath under load (position only)"),
    ),
    excitation="A wide span of tension; position for the shortening.",
    look_alikes=("load_dependent_friction",),
    law=_law,
    position=_position,
)

"""Friction of the distal pulley, which only the sensing loop runs over."""

from sstl_cli.physics.effect import FRICTION_LAW, Effect, Law, Parameter, Values


def _law(law: Law, v: Values) -> None:
    law.pulley_pull += v["m_p"]
    law.pulley_release += v["m_r"]
    law.pulley_n += v["f0_n"]


EFFECT = Effect(
    id="pulley_friction",
    title="Friction in the sensing loop's pulley",
    stage=FRICTION_LAW,
    equation="T+ = T- exp(-zeta m_zeta) - zeta f0, half-way through the SSTL",
    source="Section III-C2 (slope product of the SSTL below 1); catalogue entry [P, C]",
    parameters=(
        Parameter("m_p", "1", 0.0, 0.0, 0.25, "proportional loss at the pulley while pulling"),
        Parameter("m_r", "1", 0.0, 0.0, 0.25, "proportional loss at the pulley while releasing"),
        Parameter("f0_n", "N", 0.0, 0.0, 2.0, "constant loss at the pulley"),
    ),
    excitation="SSTL and actuation runs of the same configurations.",
    systems=("sstl",),
    variants=(("m_p", "m_r"), ("f0_n",), ("m_p",), ("m_r",), ("m_p", "m_r", "f0_n")),
    look_alikes=("gain_error", "const_friction"),
    law=_law,
)

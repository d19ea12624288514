"""Constant friction along the sheath or at its ends, whatever the tension: both propagation lines open outwards."""

from sstl_cli.physics.effect import FRICTION_LAW, Effect, Law, Parameter, Values


def _law(law: Law, v: Values) -> None:
    law.constant_n += v["w_l_n"]
    law.adhesion_n += v["w_bend_n"]
    law.begin_n += v["w_in_n"]
    law.end_n += v["w_end_n"]


EFFECT = Effect(
    id="const_friction",
    title="Constant friction along the sheath or at its ends",
    stage=FRICTION_LAW,
    equation="dT/ds = -zeta (mu kappa (T + w_bend) + w); where it is driven T -> T - zeta w_in, at the end T -> T - zeta w_end",
    source="Published extension of the capstan equation of Eq. (1); Derjaguin, Z. Phys. 88 (1934) 661 (adhesion); catalogue entry [L]",
    parameters=(
        Parameter("w_l_n", "N", 0.0, 0.0, 0.5, "friction per pass, w L"),
        # what presses a tendon on the sheath beside its tension: its stiffness, a lubricant; the same as four equal zeros (see play)
        Parameter("w_bend_n", "N", 0.0, 0.0, 1.0, "friction along the bend, as that of so much tension"),
        # a seal, a guide or the joint itself: once, whatever the passes
        Parameter("w_in_n", "N", 0.0, 0.0, 0.5, "friction where the line is driven"),
        Parameter("w_end_n", "N", 0.0, 0.0, 0.5, "friction at the end where the output is read"),
    ),
    excitation="Low tensions; both channels; at least two speeds to tell it from viscous drag.",
    look_alikes=("zero_offset", "viscous", "pulley_friction"),
    variants=(("w_l_n",), ("w_bend_n",), ("w_in_n",), ("w_end_n",), ("w_in_n", "w_end_n")),
    plays=("w_in_n", "w_end_n"),
    law=_law,
)

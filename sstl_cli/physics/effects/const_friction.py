"""Constant friction per length, whatever the tension: both propagation lines open outwards."""

from sstl_cli.physics.effect import FRICTION_LAW, Effect, Law, Parameter, Values


def _law(law: Law, v: Values) -> None:
    law.constant_n += v["w_l_n"]


EFFECT = Effect(
    id="const_friction",
    title="Constant friction along the sheath",
    stage=FRICTION_LAW,
    equation="dT/ds = -zeta (mu kappa T + w)",
    source="Published extension of the capstan equation of Eq. (1); catalogue entry [L]",
    parameters=(Parameter("w_l_n", "N", 0.0, 0.0, 0.5, "friction per pass, w L"),),
    excitation="Low tensions; both channels; at least two speeds to tell it from viscous drag.",
    look_alikes=("zero_offset", "viscous", "pulley_friction"),
    law=_law,
)

"""Friction that is stronger in one direction: the slope product leaves 1 in both channels."""

from sstl_cli.physics.effect import FRICTION_LAW, Effect, Law, Parameter, Values


def _law(law: Law, v: Values) -> None:
    law.scale_pull *= 1.0 + v["a"]
    law.scale_release *= 1.0 - v["a"]


EFFECT = Effect(
    id="asymmetric_friction",
    title="Friction that differs between pulling and releasing",
    stage=FRICTION_LAW,
    equation="mu_p = mu (1 + a), mu_r = mu (1 - a)",
    source="Catalogue entry [G]; Section III-C2",
    parameters=(Parameter("a", "1", 0.0, -0.2, 0.2, "relative difference of the friction coefficients", limits=(-0.9, 0.9)),),
    excitation="SSTL and actuation runs: the product departs squared in the SSTL.",
    look_alikes=("gain_error", "load_dependent_friction"),
    law=_law,
)

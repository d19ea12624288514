"""The pulley between the two passes: capstan exponents by direction, and a constant; its level never changes."""

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    contact, pulley = made.contact, ~made.sheathed
    contact.theta_pull[pulley], contact.theta_release[pulley], contact.bias[pulley] = v["m_p"], v["m_r"], v["f0_n"]


EFFECT = Effect({"m_p": Bounds(0.0, 0.0, 0.25), "m_r": Bounds(0.0, 0.0, 0.25), "f0_n": Bounds(0.0, 0.0, 2.0)}, build=_build)

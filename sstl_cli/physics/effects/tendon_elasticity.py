"""A tendon that stretches: a dead zone between position and tension."""

from sstl_cli.physics.effect import TRANSITION, Effect, Parameter, Position, Values


def _position(position: Position, v: Values) -> None:
    position.tendon_mm_per_n += v["compliance_per_kn"] * position.length_mm / 1000.0


EFFECT = Effect(
    id="tendon_elasticity",
    title="Elastic tendon",
    stage=TRANSITION,
    equation="dx/ds = -(T - T_pre) / EA",
    source="Section II; catalogue entry [P, L]",
    parameters=(Parameter("compliance_per_kn", "1/kN", 0.0, 0.0, 0.33, "1/EA of the tendon"),),
    excitation="Position; NP, CP and ND.",
    channel="position",
    needs=("position_in_mm",),
    look_alikes=("sheath_compliance", "load_spring"),
    position=_position,
)

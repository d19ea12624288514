"""A distal load that is no straight spring."""

from sstl_cli.physics.effect import TRANSITION, Effect, Parameter, Position, Values


def _position(position: Position, v: Values) -> None:
    position.cubic_per_mm2 += v["k3_per_mm2"]
    position.play_mm += v["play_mm"]


EFFECT = Effect(
    id="load_spring",
    title="Load spring that is not linear",
    stage=TRANSITION,
    equation="T = k1 (x + k3 x^3), with play",
    source="Catalogue entry [L]",
    parameters=(
        Parameter("k3_per_mm2", "1/mm^2", 0.0, 0.0, 0.1, "cubic over linear stiffness"),
        Parameter("play_mm", "mm", 0.0, 0.0, 2.0, "play at the load"),
    ),
    excitation="Position; a wide span of tension.",
    channel="position",
    needs=("position_in_mm",),
    look_alikes=("tendon_elasticity",),
    position=_position,
)

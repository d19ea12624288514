"""A line that goes slack: position moves while the tension stays near zero."""

from sstl_cli.physics.effect import TRANSITION, Effect, Parameter, Position, Values


def _position(position: Position, v: Values) -> None:
    position.gap_mm += v["gap_mm"]


EFFECT = Effect(
    id="slack",
    title="Slack",
    stage=TRANSITION,
    equation="T = max(0, .), with a gap of free length",
    source="Catalogue entry [L]",
    parameters=(Parameter("gap_mm", "mm", 0.0, 0.0, 5.0, "free length taken up at zero tension"),),
    excitation="Position, with the tension returning to zero.",
    channel="position",
    needs=("position_in_mm",),
    look_alikes=("saturation",),
    position=_position,
)

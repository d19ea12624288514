"""A tendon that creeps under load: position relaxes in holds."""

from sstl_cli.physics.effect import TRANSITION, Effect, Parameter, Position, Values

def _position(position: Position, v: Values) -> None:
    position.creep_fraction += v["fraction"]
    position.creep_s = v["tau_s"]


EFFECT = Effect(
    id="viscoelastic_creep",
    title="Viscoelastic tendon",
    stage=TRANSITION,
    equation="standard linear solid: du/dt = (fraction C T - u) / tau",
    source="Textbook standard linear solid; catalogue entry [G]",
    parameters=(
        Parameter("fraction", "1", 0.0, 0.0, 0.3, "creep compliance over elastic compliance"),
        Parameter("tau_s", "s", 10.0, 1.0, 100.0, "time constant", shape=True),
    ),
    excitation="Holds with position recorded.",
    channel="position",
    needs=("position_in_mm",),
    look_alikes=("viscous",),
    position=_position,
)

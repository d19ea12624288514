"""A tendon that creeps under load: position relaxes in holds."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Position, Transition, Values


def _transition(transition: Transition, v: Values, _drive: Drive) -> None:
    transition.creep_fraction += v["fraction"]
    transition.creep_s = v["tau_s"]


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
    excitation="Holds of tens of seconds; the far tendon relaxes against the load, position shows it most.",
    look_alikes=("viscous",),
    transition=_transition,
    position=_position,
)

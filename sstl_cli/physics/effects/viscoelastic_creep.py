"""A tendon that creeps under load: position relaxes in holds."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Position, Transition, Values


def _transition(transition: Transition, v: Values, _drive: Drive) -> None:
    transition.creep_fraction += v["fraction"]
    transition.creep_s, transition.creep_spread = v["tau_s"], v["spread"]


def _position(position: Position, v: Values) -> None:
    position.creep_fraction += v["fraction"]
    position.creep_s, position.creep_spread = v["tau_s"], v["spread"]


EFFECT = Effect(
    id="viscoelastic_creep",
    title="Viscoelastic tendon",
    stage=TRANSITION,
    equation="standard linear solid: du/dt = (fraction C T - u) / tau; or three Kelvin elements, a third of it each, at tau / s, tau and tau s",
    source="Textbook standard linear solid; spectrum of times, Findley, Lai, Onaran 1976, chapter 5; catalogue entry [G]",
    parameters=(
        Parameter("fraction", "1", 0.0, 0.0, 0.3, "creep compliance over elastic compliance"),
        Parameter("tau_s", "s", 10.0, 1.0, 100.0, "time constant", shape=True),
        Parameter(
            "spread",
            "1",
            1.0,
            1.0,
            10.0,
            "ratio of neighbouring time constants where there are several",
            shape=True,
            start=3.0,
            limits=(1.0, 100.0),
        ),
    ),
    variants=(("fraction", "tau_s"), ("fraction", "tau_s", "spread")),
    excitation="Holds of tens of seconds; the far tendon relaxes against the load, position shows it most.",
    look_alikes=("viscous",),
    transition=_transition,
    position=_position,
)

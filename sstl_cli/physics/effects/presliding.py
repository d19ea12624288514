"""Friction that builds up over a break-away distance: rounded corners, creeping holds, curved minor loops."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Transition, Values


def _transition(transition: Transition, v: Values, _drive: Drive) -> None:
    transition.breakaway_mm += v["breakaway_mm"]
    transition.spread = v["spread"]


EFFECT = Effect(
    id="presliding",
    title="Presliding before break-away",
    stage=TRANSITION,
    equation="dF = F_limit / z_b du, |F| <= F_limit, at every node of an elastic line",
    source="Generalised Maxwell slip / Prandtl-Ishlinskii; catalogue entry [L]",
    parameters=(
        Parameter("breakaway_mm", "mm", 0.0, 0.0, 1.5, "mean break-away distance"),
        Parameter("spread", "1", 0.5, 0.0, 1.0, "relative spread of the break-away distances", shape=True, limits=(0.0, 1.0)),
    ),
    excitation="Minor loops and frequent reversals; three speeds tell it from a low-pass.",
    look_alikes=("channel_lowpass",),
    transition=_transition,
)

"""Friction that builds up over a break-away distance: rounded corners, creeping holds, curved minor loops."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Transition, Values

BRISTLE_N = 10.0


def _transition(transition: Transition, v: Values, _drive: Drive) -> None:
    cut, dahl, bristle = v["breakaway_mm"], v["dahl_mm"], v["bristle_mm"]
    transition.breakaway_mm += cut + dahl + bristle
    # a little of one law changes the distance of the other, not the law
    if dahl > 0.0 and dahl >= cut:
        transition.tail = v["tail"]
    if cut + bristle > 0.0:
        transition.spread = v["spread"]
    if bristle > max(cut, dahl):
        transition.bristle_n = BRISTLE_N


EFFECT = Effect(
    id="presliding",
    title="Presliding before break-away",
    stage=TRANSITION,
    equation="dF = F_limit / z_b du, |F| <= F_limit; dF = F_limit(10 N) / z_b du; or dF = F_limit / z_d ((1 - s) g^(1/2) + s g) du, g = 1 - F / F_limit; at every node of an elastic line",
    source="Generalised Maxwell slip / Prandtl-Ishlinskii; bristles of one stiffness, Haessig, Friedland (1991); Dahl, TOR-158(3107-18) (1968); catalogue entry [L]",
    parameters=(
        Parameter("breakaway_mm", "mm", 0.0, 0.0, 1.5, "mean break-away distance"),
        Parameter("spread", "1", 0.5, 0.0, 1.0, "relative spread of the break-away distances", shape=True, limits=(0.0, 1.0)),
        Parameter("bristle_mm", "mm", 0.0, 0.0, 1.5, "break-away distance at 10 N of contacts that are as stiff at every tension"),
        Parameter("dahl_mm", "mm", 0.0, 0.0, 1.5, "break-away distance of friction that builds up ever more slowly"),
        Parameter(
            "tail", "1", 0.5, 0.0, 1.0, "how long the build-up takes to end, s: 1 in Dahl's law", shape=True, start=0.5, limits=(0.0, 1.0)
        ),
    ),
    excitation="Minor loops and frequent reversals; three speeds tell it from a low-pass.",
    look_alikes=("channel_lowpass",),
    variants=(("breakaway_mm", "spread"), ("bristle_mm", "spread"), ("dahl_mm", "tail")),
    transition=_transition,
)

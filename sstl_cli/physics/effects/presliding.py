"""Friction that builds up over a break-away distance: rounded corners, creeping holds, curved minor loops."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Transition, Values

def _transition(transition: Transition, v: Values, drive: Drive) -> None:
    # break-away distance over the travel that turns the friction round along the whole pass
    travel_mm = drive.mechanics.tendon_mm_per_n * TURN_ROUND_N * drive.passes
    transition.spread += v["breakaway_mm"] / travel_mm
    transition.spread_shape = v["spread"]


# tension change at the input that turns the friction of a pass round, at mid-range tension
TURN_ROUND_N = 10.0

EFFECT = Effect(
    id="presliding",
    title="Presliding before break-away",
    stage=TRANSITION,
    equation="out = sum_j w_j clip(out_j, in + c_j (pull(in) - in), in + c_j (release(in) - in)), mean of c_j = 1",
    source="Generalised Maxwell slip / Prandtl-Ishlinskii; catalogue entry [L]",
    parameters=(
        Parameter("breakaway_mm", "mm", 0.0, 0.0, 1.5, "mean break-away distance"),
        Parameter("spread", "1", 0.5, 0.0, 1.0, "relative spread of the break-away distances", shape=True),
    ),
    excitation="Minor loops and frequent reversals; three speeds tell it from a low-pass.",
    look_alikes=("channel_lowpass",),
    transition=_transition,
)

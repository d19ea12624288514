"""Static friction above kinetic friction in a springy line: a sawtooth at low speed."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Transition, Values, sliding_mm_per_n

def _transition(transition: Transition, v: Values, drive: Drive) -> None:
    transition.static_ratio *= v["ratio"]
    transition.static_rate_n_s = v["v_c_mm_s"] / sliding_mm_per_n(drive)


EFFECT = Effect(
    id="stick_slip",
    title="Stick-slip",
    stage=TRANSITION,
    equation="stick until out leaves the envelope of ratio * mu, then jump to that of mu; ratio fades with speed",
    source="Static over kinetic friction with series compliance; catalogue entry [L, T]",
    parameters=(
        Parameter("ratio", "1", 1.0, 1.0, 1.5, "static over kinetic friction"),
        Parameter("v_c_mm_s", "mm/s", 1.0, 0.1, 10.0, "speed above which sliding is smooth", shape=True),
    ),
    excitation="Slow ramps beside faster ones.",
    look_alikes=("stribeck", "dwell_aging"),
    transition=_transition,
)

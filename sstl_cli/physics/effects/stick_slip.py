"""Static friction above kinetic friction in a springy line: a sawtooth at low speed."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Law, Parameter, Transition, Values
from sstl_cli.physics.jumps import weakening


def _transition(transition: Transition, v: Values, _drive: Drive) -> None:
    transition.static_ratio *= v["ratio"]
    transition.static_mm_s = v["v_c_mm_s"]


def _law(law: Law, v: Values) -> None:
    law.following_scale += weakening(v["mean_ratio"], v["mean_mm_s"])


EFFECT = Effect(
    id="stick_slip",
    title="Stick-slip",
    stage=TRANSITION,
    equation="mu_s = ratio mu at rest; the excess renews over v_c dt and wears off with slip; on average mean_ratio, mean_mm_s",
    source="Static over kinetic friction with series compliance; catalogue entry [L, T]",
    parameters=(
        Parameter("ratio", "1", 1.0, 1.0, 1.5, "static over kinetic friction"),
        Parameter("v_c_mm_s", "mm/s", 1.0, 0.1, 10.0, "speed above which sliding is smooth", shape=True),
        Parameter("mean_ratio", "1", 1.0, 1.0, 1.5, "slow over fast friction, on average over jumps", limits=(1.0, 3.0)),
        Parameter("mean_mm_s", "mm/s", 1.0, 0.1, 10.0, "speed at which the jumps end", shape=True),
    ),
    excitation="Slow ramps beside faster ones.",
    look_alikes=("stribeck", "dwell_aging"),
    variants=(("ratio", "v_c_mm_s", "load_mm_per_n"), ("mean_ratio", "mean_mm_s")),
    averaged=("mean_ratio",),
    law=_law,
    transition=_transition,
)

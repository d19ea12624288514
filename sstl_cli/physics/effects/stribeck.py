"""Friction that falls with sliding speed, without jumps."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Law, Parameter, Transition, Values
from sstl_cli.physics.jumps import weakening


def _transition(transition: Transition, v: Values, _drive: Drive) -> None:
    transition.stribeck_ratio *= v["ratio"]
    transition.stribeck_mm_s = v["v_s_mm_s"]


def _law(law: Law, v: Values) -> None:
    law.following_scale += weakening(v["mean_ratio"], v["mean_mm_s"])


EFFECT = Effect(
    id="stribeck",
    title="Friction that falls with speed (Stribeck)",
    stage=TRANSITION,
    equation="mu(v) = mu_c (1 + (ratio - 1) exp(-(v / v_s)^2)); on average over jumps mean_ratio, mean_mm_s",
    source="Stribeck curve as in the LuGre model; catalogue entry [L, T]",
    parameters=(
        Parameter("ratio", "1", 1.0, 1.0, 1.5, "static over kinetic friction"),
        Parameter("v_s_mm_s", "mm/s", 1.0, 0.1, 10.0, "Stribeck speed", shape=True),
        Parameter("mean_ratio", "1", 1.0, 1.0, 1.5, "slow over fast friction, on average over jumps", limits=(1.0, 3.0)),
        Parameter("mean_mm_s", "mm/s", 1.0, 0.1, 10.0, "speed at which the jumps end", shape=True),
    ),
    excitation="At least two, better three, speeds a decade apart.",
    look_alikes=("stick_slip", "viscous"),
    variants=(("ratio", "v_s_mm_s", "load_mm_per_n"), ("mean_ratio", "mean_mm_s")),
    averaged=("mean_ratio",),
    law=_law,
    transition=_transition,
)

"""Contacts that strengthen at rest: an overshoot after a hold that grows with its length."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Transition, Values


def _transition(transition: Transition, v: Values, _drive: Drive) -> None:
    transition.aging += v["b"]
    transition.aging_s = v["t0_s"]


EFFECT = Effect(
    id="dwell_aging",
    title="Friction that strengthens at rest",
    stage=TRANSITION,
    equation="F_s = F_c (1 + b ln(1 + t_rest / t0))",
    source="Rate-and-state friction; catalogue entry [L]",
    parameters=(
        Parameter("b", "1", 0.0, 0.0, 0.05, "growth of static friction per e-fold of rest"),
        Parameter("t0_s", "s", 1.0, 0.1, 10.0, "rest after which it starts", shape=True),
    ),
    excitation="Holds of several lengths, each followed by motion.",
    look_alikes=("stick_slip",),
    transition=_transition,
)

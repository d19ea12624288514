"""Viscous drag along the tendon: the loop opens with speed and relaxes in holds."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Transition, Values


def _transition(transition: Transition, v: Values, _drive: Drive) -> None:
    transition.drag_n_s_mm += v["c_l_n_s_per_mm"]
    transition.drag_bend_n_s_mm += v["c_bend_n_s_per_mm"]


EFFECT = Effect(
    id="viscous",
    title="Viscous drag along the tendon",
    stage=TRANSITION,
    equation="(c ds + c_bend dphi) du/dt = EA u'' - friction (tension diffuses along the tendon)",
    source="Lubricated sheaths, catalogue entry [L]; textbook overstress (Perzyna) form",
    parameters=(
        Parameter("c_l_n_s_per_mm", "N s/mm", 0.0, 0.0, 0.05, "drag per pass and speed, c L"),
        Parameter("c_bend_n_s_per_mm", "N s/mm", 0.0, 0.0, 0.05, "drag per radian of bend (mu Phi) and speed"),
    ),
    excitation="Two speeds or holds after fast ramps.",
    look_alikes=("channel_delay", "channel_lowpass", "const_friction"),
    variants=(("c_l_n_s_per_mm",), ("c_bend_n_s_per_mm",)),
    transition=_transition,
)

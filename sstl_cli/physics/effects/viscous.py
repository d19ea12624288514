"""Viscous drag along the tendon or at its end: the loop opens with speed and relaxes in holds."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Transition, Values


def _transition(transition: Transition, v: Values, drive: Drive) -> None:
    transition.drag_n_s_mm += v["c_l_n_s_per_mm"]
    transition.drag_bend_n_s_mm += v["c_bend_n_s_per_mm"]
    transition.drag_end_n_s_mm += v["c_end_n_s_per_mm"] * drive.passes + v["c_seal_n_s_per_mm"]
    transition.drag_power = v["power"]


EFFECT = Effect(
    id="viscous",
    title="Viscous drag along the tendon or at its end",
    stage=TRANSITION,
    equation="(c ds + c_bend dphi) du/dt = EA u'' - friction (tension diffuses along the tendon), or c |du/dt|^n; at the end T -> T - c_end du/dt",
    source="Lubricated sheaths, catalogue entry [L]; textbook overstress (Perzyna) form; Ostwald-de Waele (shear-thinning grease)",
    parameters=(
        Parameter("c_l_n_s_per_mm", "N s/mm", 0.0, 0.0, 0.05, "drag per pass and speed, c L"),
        Parameter("c_bend_n_s_per_mm", "N s/mm", 0.0, 0.0, 0.05, "drag per radian of bend (mu Phi) and speed"),
        Parameter(
            "power",
            "1",
            1.0,
            0.4,
            1.0,
            "power of the speed that drag goes with, as it is at 1 mm/s",
            shape=True,
            start=0.6,
            limits=(0.2, 1.0),
        ),
        Parameter("c_end_n_s_per_mm", "N s/mm", 0.0, 0.0, 0.05, "drag per pass met at the end where the output is read, by speed"),
        # of a seal, a guide or the joint itself: once, whatever the passes
        Parameter("c_seal_n_s_per_mm", "N s/mm", 0.0, 0.0, 0.05, "drag of the end where the output is read, by speed"),
    ),
    excitation="Two speeds or holds after fast ramps.",
    look_alikes=("channel_delay", "channel_lowpass", "const_friction"),
    variants=(("c_l_n_s_per_mm",), ("c_l_n_s_per_mm", "power"), ("c_bend_n_s_per_mm",), ("c_end_n_s_per_mm",), ("c_seal_n_s_per_mm",)),
    transition=_transition,
)

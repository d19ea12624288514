"""Drag that grows with the sliding speed; on an elastic tendon it lets tension diffuse."""

from sstl_cli.physics.effect import TRANSITION, Drive, Effect, Parameter, Transition, Values

def _transition(transition: Transition, v: Values, drive: Drive) -> None:
    mechanics = drive.mechanics
    # overstress over a pass = c_L v: moving the load spring gives a lag, stretching the tendon diffusion
    transition.lag_s += v["c_l_n_s_per_mm"] * mechanics.load_mm_per_n
    transition.diffusion_s += v["c_l_n_s_per_mm"] * mechanics.tendon_mm_per_n


EFFECT = Effect(
    id="viscous",
    title="Viscous drag along the tendon",
    stage=TRANSITION,
    equation="c du/dt = EA u'' - friction (tension diffuses along the tendon)",
    source="Lubricated sheaths, catalogue entry [L]; textbook overstress (Perzyna) form",
    parameters=(Parameter("c_l_n_s_per_mm", "N s/mm", 0.0, 0.0, 0.05, "drag per pass and speed, c L"),),
    excitation="Two speeds or holds after fast ramps.",
    look_alikes=("channel_delay", "channel_lowpass", "const_friction"),
    transition=_transition,
)

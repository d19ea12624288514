"""Sensors of different sensitivity, in a ratio that both share or by a pull that straightens under load."""

import numpy as np

from sstl_cli.physics.variant.effect import Effect, Reading, Values, wide
from sstl_cli.physics.variant.laws import Chosen, Law

LAWS = (
    Law("both_sensors", "out sqrt(g), in 1/sqrt(g)", "only the ratio shows: both sensors share it"),
    Law("off_axis", "1 + (g - 1) 1.4 T / (T + s)", "a line of pull that straightens under load, geometry", 2.0, 6.0),
)


def _sense(seen: Reading, v: Values, law: Chosen) -> None:
    gain = v[f"g_{seen.system}"]
    if law.id == "both_sensors":
        seen.t_in, seen.t_out = seen.t_in / np.sqrt(gain), seen.t_out * np.sqrt(gain)
    else:
        pull = np.maximum(seen.t_out, 0.0)
        seen.t_out = seen.t_out * (1.0 + (gain - 1.0) * 1.4 * pull / (pull + law.shape))


EFFECT = Effect({f"g_{system}": wide(1.0, 0.85, 1.15) for system in ("act", "sstl")}, LAWS, order=55, sense=_sense)

"""What is left of friction that falls with speed where a line jumps: its mean over the jumps, whose moments nobody knows."""

from collections.abc import Callable

import numpy as np

from sstl_cli.physics.effect import Array, Drive


def weakening(ratio: float, speed_mm_s: float) -> list[Callable[[Drive], Array]]:
    """Return the factor on the friction of a line that follows its input, over that at high speed; none at a ratio of 1."""
    if ratio == 1.0:
        return []

    def scale(drive: Drive) -> Array:
        speed = np.abs(drive.rate_n_s) * drive.mechanics.slip_mm_per_n(drive.system)
        return np.asarray(1.0 + (ratio - 1.0) * np.exp(-((speed / speed_mm_s) ** 2)))

    return [scale]

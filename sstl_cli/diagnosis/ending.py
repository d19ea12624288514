"""Friction at the end where the output is read, of a rig that is known to do more than its model.

Whatever a line does arrives there with what no law describes: a seal or the joint itself holds back both. What an accepted
model holds of such friction stays in its line, beside which it was learned what else the rig does; more of it acts on the whole.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.filters import play

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, float]]
EFFECT, PARAMETER = "const_friction", "w_end_n"


class Parted(NamedTuple):
    """Effects with the friction at the end that the line has, and what is more (N)."""

    effects: Effects
    more_n: float


def parted(effects: Effects, fixed: Effects) -> Parted:
    """Return effects with no more friction at the end than the accepted model's, and the rest.

    Parameters
    ----------
    effects, fixed : mapping
        Values of what is asked for, changes included, and of the accepted model.
    """
    has = fixed.get(EFFECT, {}).get(PARAMETER, 0.0)
    more = effects.get(EFFECT, {}).get(PARAMETER, 0.0) - has
    if more <= 0.0:
        return Parted(effects, 0.0)
    return Parted({**effects, EFFECT: {**effects[EFFECT], PARAMETER: has}}, more)


def held_back(arriving: Array, more_n: float, at: NDArray[np.int64], begin: Array) -> Array:
    """Return what is left of tensions (N) that have to overcome friction both ways; at the samples ``at`` it begins anew (N, NaN: as it arrives).

    The first sample is one of them.
    """
    pieces = zip(np.split(arriving, at[1:]), begin, strict=True)
    return np.concatenate([play(x, more_n, None if np.isnan(b) else float(b)) for x, b in pieces])

"""Both ends of the input side: the tension loop before the line, and what the recorded position holds beside stretch."""

from __future__ import annotations

import numpy as np

from sstl_cli.physics.variant.filters import first_order, second_order
from sstl_cli.physics.variant.laws import Chosen
from sstl_cli.physics.variant.line import Array


def follow(time: Array, command: Array, tau_s: float, inverse_slew: float, law: Chosen) -> Array:
    """Return the input tension (N) that a tension loop makes of its command; the command itself at neutral values."""
    if tau_s == 0.0 and inverse_slew == 0.0:
        return command
    if law.id == "second_order":
        return second_order(time, command, tau_s, law.shape, inverse_slew)
    late = np.interp(time - 0.5 * tau_s, time, command) if tau_s > 0.0 else command
    return first_order(time, late, 0.5 * tau_s, inverse_slew)


def extra_travel(tension: Array, compliance: float, sheath: Chosen, gap_mm: float, slack: Chosen) -> Array:
    """Return what a shortening sheath and slack add to the position (mm)."""
    shortened = compliance * tension * (1.0 + tension / 50.0)
    if sheath.id == "stop":
        shortened = compliance * sheath.shape * -np.expm1(-tension / sheath.shape)
    if slack.id == "catenary":
        taken = tension**2 / (tension**2 + slack.shape**2)
    else:
        taken = -np.expm1(-tension / slack.shape)
    return np.asarray(shortened + gap_mm * taken)

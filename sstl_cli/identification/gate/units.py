"""Which slip of unit a factor betrays, and how the mapping states a unit."""

from __future__ import annotations

import math

from sstl_cli.core.units import UNITS

# daN and cN are 2 % away from kgf and gf, which a factor does not tell; no load cell shows dN or dyn by itself
FORCES = {name: factor for name, (kind, factor) in UNITS.items() if kind == "force" and name not in ("daN", "cN", "dN", "dyn")}
# largest reading of volts
VOLTS = 10.0
CHANNELS = ("tension_in_n", "tension_out_n")
WORDS = ("input", "output")


def force_unit(factor: float, tolerance: float = 0.15) -> str | None:
    """Return the unit of force that is ``factor`` newtons, None where none is near.

    Examples
    --------
    >>> force_unit(4.4), force_unit(0.00102), force_unit(2.0)
    ('lbf', 'mN', None)
    """
    near = {
        name: abs(math.log(factor / size)) for name, size in FORCES.items() if name != "N" and factor > 0.0
    }  # fmt: skip
    name = min(near, key=near.__getitem__, default=None)
    return name if name is not None and near[name] < tolerance else None


def plausible_units(largest: float, low: float = 2.0, high: float = 600.0) -> list[str]:
    """Return the units of force in which a largest reading is a tension that tendons bear, most likely first.

    Examples
    --------
    >>> plausible_units(30000.0)
    ['mN', 'gf']
    """
    usual = math.log(30.0)
    fits = [n for n, size in FORCES.items() if n not in ("N", "uN", "ozf") and low <= largest * size <= high]
    return sorted(fits, key=lambda n: abs(math.log(largest * FORCES[n]) - usual))


def or_gain(factor: float, largest: float) -> str:
    """Return what else a channel may be whose readings are ``factor`` times what they should be, and ``largest`` at the most.

    Examples
    --------
    >>> or_gain(0.1, 2.6), or_gain(4.4, 120.0)
    (', or in volts or at another gain (0.1 per N)', '')
    """
    return f", or in volts or at another gain ({factor:.3g} per N)" if largest < VOLTS else ""


def stated(channel: int, unit: str, more: str = "") -> str:
    """Return the mapping's line that states the unit of a tension channel (0 input, 1 output)."""
    return f'{CHANNELS[channel]} = {{ column = ..., unit = "{unit}"{more} }}'


def column_line(channel: int) -> str:
    """Return the mapping line that takes another column for a channel (0: input, 1: output)."""
    return f"{CHANNELS[channel]} = {{ column = (the column of the {WORDS[channel]} sensor) }}"

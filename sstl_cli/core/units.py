"""Units by name: how a recorded number becomes newtons, seconds or millimetres."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sstl_cli.core.errors import SstlError, nearest

STANDARD_GRAVITY = 9.80665
POUND_KG = 0.45359237

# unit -> (dimension, factor to N, s, mm, rad, Pa, V or 1)
UNITS: dict[str, tuple[str, float]] = {
    "N": ("force", 1.0),
    "mN": ("force", 1e-3),
    "uN": ("force", 1e-6),
    "kN": ("force", 1e3),
    "daN": ("force", 10.0),
    "cN": ("force", 1e-2),
    "dN": ("force", 1e-1),
    "dyn": ("force", 1e-5),
    "kgf": ("force", STANDARD_GRAVITY),
    "gf": ("force", STANDARD_GRAVITY * 1e-3),
    "lbf": ("force", STANDARD_GRAVITY * POUND_KG),
    "ozf": ("force", STANDARD_GRAVITY * POUND_KG / 16),
    "s": ("time", 1.0),
    "ms": ("time", 1e-3),
    "us": ("time", 1e-6),
    "ns": ("time", 1e-9),
    "min": ("time", 60.0),
    "h": ("time", 3600.0),
    "mm": ("length", 1.0),
    "m": ("length", 1e3),
    "cm": ("length", 10.0),
    "um": ("length", 1e-3),
    "in": ("length", 25.4),
    "rad": ("angle", 1.0),
    "deg": ("angle", math.pi / 180),
    "rev": ("angle", 2 * math.pi),
    "Pa": ("pressure", 1.0),
    "kPa": ("pressure", 1e3),
    "MPa": ("pressure", 1e6),
    "bar": ("pressure", 1e5),
    "mbar": ("pressure", 1e2),
    "psi": ("pressure", STANDARD_GRAVITY * POUND_KG / 0.0254**2),
    "V": ("voltage", 1.0),
    "mV": ("voltage", 1e-3),
    "uV": ("voltage", 1e-6),
    "counts": ("count", 1.0),
}
_ALIASES = {
    "µs": "us",
    "μs": "us",
    "µm": "um",
    "μm": "um",
    "µN": "uN",
    "μN": "uN",
    "µV": "uV",
    "μV": "uV",
    "sec": "s",
    "second": "s",
    "seconds": "s",
    "msec": "ms",
    "usec": "us",
    "°": "deg",
    "degree": "deg",
    "degrees": "deg",
    "inch": "in",
    "newton": "N",
    "newtons": "N",
    "kg": "kgf",
    "g": "gf",
    "lb": "lbf",
    "lbs": "lbf",
    "oz": "ozf",
    "volt": "V",
    "volts": "V",
    "radian": "rad",
    "radians": "rad",
    "minute": "min",
    "minutes": "min",
    "cnt": "counts",
    "ticks": "counts",
}
BASE = {"force": "N", "time": "s", "length": "mm", "angle": "rad", "pressure": "Pa", "voltage": "V", "count": "1"}


@dataclass(frozen=True)
class Linear:
    """The conversion ``factor * (raw - offset)``."""

    factor: float
    offset: float = 0.0


def unit_of(name: str, where: str = "") -> tuple[str, float]:
    """Return the dimension of a unit and its factor to the base unit.

    Raises
    ------
    SstlError
        If the name is unknown; the nearest known unit is named.

    Examples
    --------
    >>> unit_of("mN")
    ('force', 0.001)
    """
    name = name.strip()
    name = _ALIASES.get(name, name)
    if name not in UNITS:
        lower = {u.lower(): u for u in [*UNITS, *_ALIASES]}
        hint = f"did you mean '{lower[name.lower()]}'?" if name.lower() in lower else nearest(name, UNITS)
        raise SstlError(f"unknown unit '{name}'", where=where, fix=hint, code="E301")
    return UNITS[name]


def is_unit(name: str) -> bool:
    """Return whether ``name`` is the name of a known unit."""
    return _ALIASES.get(name.strip(), name.strip()) in UNITS


def is_force(name: str) -> bool:
    """Return whether ``name`` is a unit of force."""
    return is_unit(name) and unit_of(name)[0] == "force"


def conversion(
    unit: str,
    target: str,
    *,
    gain: float | None = None,
    radius_mm: float | None = None,
    area_mm2: float | None = None,
    offset: float = 0.0,
    sign: int = 1,
    where: str = "",
) -> Linear:
    """Return how a raw reading in ``unit`` becomes the base unit of ``target``.

    Parameters
    ----------
    unit : str
        Unit of the raw reading.
    target : str
        Wanted dimension: ``force`` (N), ``time`` (s) or ``length`` (mm).
    gain : float, optional
        Target units per raw unit, for voltages and counts (N/V, mm/V, N/count).
    radius_mm : float, optional
        Spool radius in mm, from an angle to a length.
    area_mm2 : float, optional
        Piston area in mm2, from a pressure to a force.
    offset : float
        Raw reading at zero, in ``unit``.
    sign : int
        1 or -1.
    """
    dimension, factor = unit_of(unit, where)
    if gain is not None and dimension in ("voltage", "count"):
        return Linear(sign * gain * (factor if dimension == "voltage" else 1.0), offset)
    if gain is not None:
        fix = f"leave the gain out; for a correction factor on {unit} write scale = {gain:g}"
        raise SstlError(f"a gain belongs to V or counts, not to {unit}", where=where, fix=fix, code="E302")
    if dimension == target:
        return Linear(sign * factor, offset)
    if dimension == "angle" and target == "length":
        if radius_mm is None:
            fix = f'write {{ ..., unit = "{unit}", radius_mm = 8.5 }} with the radius of your spool'
            raise SstlError(f"{unit} needs a spool radius to become mm", where=where, fix=fix, code="E302")
        return Linear(sign * factor * radius_mm, offset)
    if dimension == "pressure" and target == "force":
        if area_mm2 is None:
            fix = f'write {{ ..., unit = "{unit}", bore_mm = 25 }} with the bore of your cylinder, or area_mm2'
            raise SstlError(f"{unit} needs a piston area to become N", where=where, fix=fix, code="E302")
        return Linear(sign * factor * area_mm2 * 1e-6, offset)
    raise _no_way(unit, dimension, target, where)


def _no_way(unit: str, dimension: str, target: str, where: str) -> SstlError:
    """Return the error for a unit that no number known of it leads from to the target."""
    base = BASE.get(target, target)
    if dimension in ("voltage", "count"):
        per = "V" if dimension == "voltage" else "count"
        fix = (
            f'write {{ ..., unit = "{unit}", gain = G, offset = Z }} with G in {base} per {per} from the calibration '
            f"and Z the reading in {unit} at no load"
        )
        return SstlError(f"{unit} needs a gain to become {base}", where=where, fix=fix, code="E302")
    known = ", ".join(u for u, (d, _) in UNITS.items() if d == target)
    keep = f'; an output that is no {target}: add as = "N"' if target == "force" else ""
    article = "an" if dimension == "angle" else "a"
    fix = f"correct the column, or use one of {known}{keep}"
    return SstlError(f"{unit} is {article} {dimension}, not a {target}", where=where, fix=fix, code="E302")

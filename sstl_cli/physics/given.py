"""What the simulators that stand in for hardware are given, found and checked alike: names, ranges and noise, but no law."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from math import isfinite
from typing import Any, NamedTuple, TypedDict

Values = dict[str, dict[str, float]]
# ends of ranges that are made by arithmetic may be a rounding off
ROUNDING = 1e-9


class Bounds(NamedTuple):
    """Neutral value of one effect parameter, and the range in which a simulator's law for it holds.

    Its unit stands with the effect, in the catalogue, and is part of its name.
    """

    neutral: float
    low: float
    high: float


class Built(TypedDict):
    """Geometry and mechanics, under the names that the specifications of all these simulators give them."""

    length_mm: float
    ea_n: float
    nodes: int
    bend_arc_fraction: float
    bend_centres: dict[str, float]
    load_k1_n_per_mm: float


def require(simulator: str, holds: object, name: str, value: object, rule: str) -> None:
    """Raise ValueError that names a field of what a simulator is given, its value and the rule it broke, unless that holds."""
    if not holds:
        raise ValueError(f"{simulator}: {name} = {value} must be {rule}")


@dataclass(frozen=True)
class NoiseSpec:
    """Noise, independent for each sensor: white and first-order coloured tension noise (N RMS), position (mm RMS).

    Raises
    ------
    ValueError
        A level is negative or the correlation time (s) is not positive.
    """

    white_n: float = 0.02
    coloured_n: float = 0.0
    correlation_s: float = 0.3
    position_mm: float = 0.0

    def __post_init__(self) -> None:
        for name in ("white_n", "coloured_n", "position_mm"):
            value = getattr(self, name)
            require("noise", isfinite(value) and value >= 0.0, name, value, "finite and >= 0")
        require("noise", isfinite(self.correlation_s) and self.correlation_s > 0.0, "correlation_s", self.correlation_s, "> 0 s")


QUIET = NoiseSpec(white_n=0.0)


def discovered(package: str, folders: Iterable[str]) -> dict[str, Any]:
    """Return ``EFFECT`` of every module of a package: one file, one effect, by its name, in the order in which they act."""
    found = {m.name: importlib.import_module(f"{package}.{m.name}").EFFECT for m in pkgutil.iter_modules(folders)}
    return dict(sorted(found.items(), key=lambda named: (named[1].order, named[0])))


def resolved(simulator: str, known: Mapping[str, Mapping[str, Bounds]], effects: Mapping[str, Mapping[str, float]]) -> Values:
    """Return every parameter of every effect that a simulator knows, neutral where `effects` is silent.

    Raises
    ------
    ValueError
        An id or a parameter is unknown, or a value is not finite or outside its range.

    Examples
    --------
    >>> resolved("rig", {"slack": {"gap_mm": Bounds(0.0, 0.0, 5.0)}}, {})
    {'slack': {'gap_mm': 0.0}}
    """
    full = {effect: {name: b.neutral for name, b in table.items()} for effect, table in known.items()}
    for effect, given in effects.items():
        _named(simulator, "effect", effect, known)
        for name, value in given.items():
            _named(simulator, f"parameter of {effect}", name, known[effect])
            _, low, high = known[effect][name]
            number = float(value)
            if not isfinite(number) or not low - ROUNDING <= number <= high + ROUNDING:
                raise ValueError(f"{simulator}: {effect}.{name} = {value} is outside {low:g}..{high:g}")
            full[effect][name] = number
    return full


def _named(simulator: str, kind: str, name: str, known: Mapping[str, object]) -> None:
    if name not in known:
        near = get_close_matches(name, known, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"{simulator}: unknown {kind} {name!r}{hint} (known: {', '.join(sorted(known))})")

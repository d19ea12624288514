"""What the simulators that stand in for hardware are given and give back, checked alike: names, ranges, noise, runs and records, but no law."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from math import isfinite
from typing import ClassVar, NamedTuple, Protocol, TypedDict, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

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


@dataclass(frozen=True)
class GivenRun:
    """One run to record: configuration, time base and command.

    Parameters
    ----------
    system : "act" (one pass) or "sstl" (there and back around a distal pulley).
    theta : mu * Phi of one pass, dimensionless, 0..3.
    location : "NP", "CP", "ND" or None (taken as CP).
    time_s : shape (n,), strictly increasing, s.
    drive : "tension" (command is T_in in N, imposed exactly), "position" (command is motor travel in mm from the
        pretensioned rest) or "loop" (command is T_cmd in N, tracked by the PID and the motor).
    command : shape (n,).
    neighbour_n : shape (n,), N, summed tension of the other tendons in the tube, or None.

    Raises
    ------
    ValueError
        A field is unknown, misshapen, not finite or out of range.
    """

    simulator: ClassVar[str]
    drives: ClassVar[tuple[str, ...]] = ("tension", "position", "loop")
    signals: ClassVar[tuple[str, ...]] = ("time_s", "command", "neighbour_n")

    system: str
    theta: float
    location: str | None
    time_s: FloatArray
    drive: str
    command: FloatArray
    neighbour_n: FloatArray | None = None

    def __post_init__(self) -> None:
        for name, known in (("system", ("act", "sstl")), ("drive", self.drives)):
            self._require(getattr(self, name) in known, name, repr(getattr(self, name)), f"one of {', '.join(known)}")
        self._require(isfinite(self.theta) and 0.0 <= self.theta <= 3.0, "theta", self.theta, "in 0..3")
        for name in self.signals:
            if getattr(self, name) is None:
                continue
            signal = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            object.__setattr__(self, name, signal)
            shape = f"shape {signal.shape}"
            self._require(signal.ndim == 1 and signal.size >= 2, name, shape, "of two samples or more")
            self._require(signal.shape == self.time_s.shape, name, shape, f"of shape {self.time_s.shape}, as time_s")
            self._require(np.all(np.isfinite(signal)), name, "[...]", "finite")
        self._require(np.all(np.diff(self.time_s) > 0.0), "time_s", "[...]", "strictly increasing, s")

    def _require(self, holds: object, name: str, value: object, rule: str) -> None:
        require(self.simulator, holds, name, value, rule)


@dataclass(frozen=True)
class Recorded:
    """Record of one run: arrays of shape (n,) after sensors and noise, the truth beside them, and the health of the solution.

    `position_in_mm` is the motor travel from the pretensioned rest. `unconverged` counts samples that were given up on,
    `substepped` those that were divided. Energies (J) are the work against friction and drag; `min_step_dissipation_j` is the
    smallest of one step. `node_tension` has shape (n, springs), N, drive end first, when asked for.
    """

    time_s: FloatArray
    tension_in_n: FloatArray
    tension_out_n: FloatArray
    position_in_mm: FloatArray
    true_tension_in_n: FloatArray
    true_tension_out_n: FloatArray
    true_position_in_mm: FloatArray
    unconverged: int
    substepped: int
    iterations: int
    dissipated_j: float
    min_step_dissipation_j: float
    node_tension: FloatArray | None = None


class Ordered(Protocol):
    """What a simulator has for an effect, as far as it goes by: its place among the others."""

    @property
    def order(self) -> int: ...


E = TypeVar("E", bound=Ordered)


def discovered(kind: type[E], package: str, folders: Iterable[str]) -> dict[str, E]:
    """Return ``EFFECT`` of every module of a package: one file, one effect, by its name, in the order in which they act.

    Raises
    ------
    TypeError
        One is not of this kind: it was made for another simulator.
    """
    found = {}
    for name in (m.name for m in pkgutil.iter_modules(folders)):
        effect = importlib.import_module(f"{package}.{name}").EFFECT
        if not isinstance(effect, kind):
            raise TypeError(f"{package}.{name}.EFFECT is no {kind.__module__}.{kind.__name__}")
        found[name] = effect
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

"""What an effect declares: its equation, parameters, excitation and the code of its stage."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError, nearest

Array = NDArray[np.float64]
Values = Mapping[str, float]

FRICTION_LAW, TRANSITION, INSTRUMENT = "friction law", "transition", "instrument"
STAGES = (FRICTION_LAW, TRANSITION, INSTRUMENT)
REACH, SHAPE_REACH = 10.0, 3.0
# mu Phi of one pass (rad) in the middle of what tubes have
NOMINAL_THETA = 0.53
# units that go with the size of the forces
FORCE_UNITS = ("N", "N s/mm", "1/N", "mm/N", "1/kN", "s/N")


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect.

    ``neutral`` switches it off, wherever it lies; a ``shape`` parameter matters only while the others are not neutral. ``low`` and ``high``
    are where to look first; ``least`` and ``most`` are where its meaning ends, by default ten times as far (shapes: three).
    """

    name: str
    unit: str
    neutral: float
    low: float
    high: float
    meaning: str
    shape: bool = False
    start: float | None = None
    system: str | None = None
    limits: tuple[float | None, float | None] = (None, None)

    @property
    def least(self) -> float:
        """Smallest value that has a meaning."""
        given = self.limits[0]
        if given is not None:
            return given
        if self.low == self.neutral:
            return self.low
        reach = SHAPE_REACH if self.shape else REACH
        return self.low / reach if self.low > 0.0 else self.low * reach

    @property
    def most(self) -> float:
        """Largest value that has a meaning."""
        given = self.limits[1]
        if given is not None:
            return given
        return self.high if self.high == self.neutral else self.high * (SHAPE_REACH if self.shape else REACH)


SYSTEMS = ("act", "sstl")
# sides and systems of the four sensors, in the order of their parameters
SENSORS = tuple((side, system) for system in SYSTEMS for side in ("in", "out"))


def sensor_name(side: str, system: str) -> str:
    """Return the name of a sensor in words.

    Examples
    --------
    >>> sensor_name("in", "sstl"), sensor_name("out", "act")
    ('SSTL input', 'actuation output')
    """
    return f"{'SSTL' if system == 'sstl' else 'actuation'} {side}put"


@dataclass
class Law:
    """The friction law of one pass, of the pulley between two passes and of both ends, built up by effects.

    ``factors`` multiply the local Coulomb friction ``mu kappa T``; each takes the local tension in N. ``adhesion_n`` presses as so
    much tension does, ``constant_n`` is spread over the length. ``friction_scale`` are factors over time of all friction, of a line that
    is held as well; ``following_scale`` of that of a line that follows its input.
    """

    scale_pull: float = 1.0
    scale_release: float = 1.0
    factors: list[Callable[[Array], Array]] = field(default_factory=list)
    constant_n: float = 0.0
    adhesion_n: float = 0.0
    begin_n: float = 0.0
    end_n: float = 0.0
    pulley_pull: float = 0.0
    pulley_release: float = 0.0
    pulley_n: float = 0.0
    friction_scale: list[Callable[[Drive], Array]] = field(default_factory=list)
    following_scale: list[Callable[[Drive], Array]] = field(default_factory=list)


@dataclass
class Transition:
    """How the output moves between the envelopes, built up by effects; the defaults are a pure play.

    Friction builds up in proportion to the way and is cut, or with a ``tail`` of 0 or more ever more slowly. Contacts are as stiff
    as ``breakaway_mm`` says at any tension, or, where it is above 0, at ``bristle_n`` (N) and so at all others. Drag goes with
    a power of the speed; its coefficients are those at 1 mm/s.
    """

    breakaway_mm: float = 0.0
    spread: float = 0.0
    tail: float = -1.0
    bristle_n: float = 0.0
    drag_n_s_mm: float = 0.0
    drag_bend_n_s_mm: float = 0.0
    drag_end_n_s_mm: float = 0.0
    drag_power: float = 1.0
    creep_fraction: float = 0.0
    creep_s: float = 10.0
    creep_spread: float = 1.0
    static_ratio: float = 1.0
    static_mm_s: float = 1.0
    aging: float = 0.0
    aging_s: float = 1.0
    stribeck_ratio: float = 1.0
    stribeck_mm_s: float = 1.0


@dataclass(frozen=True)
class Mechanics:
    """Tube and tendon as built (not fitted): lengths in mm, stiffness in N and N/mm, friction of the loop over that of the actuation tendon.

    The loop ends at ``loop_load_n_per_mm``, or at a load as stiff as the tendon's where none is given. Where a pair that is stretched
    by ``preload_n`` (N) against each other drives a system, its readings are what one tendon carries beyond the preload.
    """

    length_mm: float = 2000.0
    ea_n: float = 8000.0
    load_n_per_mm: float = 8.0
    arc_fraction: float = 0.25
    bend_centres: Mapping[str, float] = field(default_factory=lambda: {"NP": 0.2, "CP": 0.5, "ND": 0.8})
    loop_friction: float = 1.0
    loop_load_n_per_mm: float | None = None
    preload_n: Mapping[str, float] = field(default_factory=dict)

    def friction(self, system: str) -> float:
        """Return the factor on theta of a system."""
        return self.loop_friction if system == "sstl" else 1.0

    def preload(self, system: str) -> float:
        """Return by how much (N) the tendon of a system is stretched where it reads nothing, 0 where it only pulls."""
        return self.preload_n.get(system, 0.0)

    @property
    def tendon_mm_per_n(self) -> float:
        """Compliance of one pass of tendon."""
        return self.length_mm / self.ea_n

    def end_n_per_mm(self, system: str) -> float:
        """Return the stiffness of what a system ends at: the load spring, or what holds the far end of the loop."""
        return self.load_n_per_mm if system != "sstl" or self.loop_load_n_per_mm is None else self.loop_load_n_per_mm

    def end_mm_per_n(self, system: str) -> float:
        """Return the compliance of what a system ends at."""
        return 1.0 / self.end_n_per_mm(system)

    def slip_mm_per_n(self, system: str) -> float:
        """Return by how much a line slips in the middle of a pass for what its tension changes by."""
        return 0.5 * self.tendon_mm_per_n + self.end_mm_per_n(system)

    def straight(self, location: str | None) -> tuple[float, float]:
        """Return the share of the length before and behind the bend."""
        centre = self.bend_centres.get(location or "CP", 0.5)
        before = min(max(centre - self.arc_fraction / 2, 0.0), 1.0 - self.arc_fraction)
        return before, 1.0 - self.arc_fraction - before


@dataclass(frozen=True)
class Drive:
    """What drives one run: equally spaced time (s), true input tension (N) and its derivatives.

    ``knots`` are the samples at which an elastic line is marched: a coarser grid and all turning points.
    ``slip`` is the direction of slip (1 pulling, -1 releasing, 0 unknown) where a recorded motion sets it.
    ``neighbour_n`` is the summed tension (N) of tendons that were pulled beside, None where there are none.
    """

    system: str
    location: str | None
    dt_s: float
    time_s: Array
    tension_n: Array
    rate_n_s: Array
    path_n: Array
    mechanics: Mechanics
    knots: NDArray[np.int64]
    slip: Array | None = None
    neighbour_n: Array | None = None

    @property
    def passes(self) -> int:
        return 2 if self.system == "sstl" else 1


# An instrument hook takes (signal, other tension, drive-like context, parameter values).
Hook = Callable[[Array, Array, "Sampling", Values], Array]


@dataclass(frozen=True)
class Sampling:
    """What a sensor hook may know of the run: channel pair, sampling period (s), number of samples, what the output reads first (N),
    theta (rad; the middle of what is usual where nobody knows it), when in its session it began (s), and at which tension (N) an
    output in another unit reads nothing.
    """

    system: str
    dt_s: float
    count: int
    rng: np.random.Generator | None = None
    begin_n: float | None = None
    theta: float = NOMINAL_THETA
    begun_s: float = 0.0
    zero_n: float = 0.0

    @property
    def fraction(self) -> Array:
        """Time from 0 to 1 over the run, shape (count,)."""
        return _fraction(self.count)


@lru_cache(maxsize=64)
def _fraction(count: int) -> Array:
    found = np.linspace(0.0, 1.0, count)
    found.flags.writeable = False
    return found


@dataclass(frozen=True)
class Effect:
    """One unmodelled effect, declared once for simulation, diagnosis, documentation and tests.

    At neutral parameter values every hook is exactly the identity, so that models nest.
    ``output`` maps a true to a measured output; ``input`` a true to a measured input and
    ``input_inverse`` back; ``position`` and ``loop`` act on channels that are recorded beside; ``late_s`` says by how much (s) the output of a
    system is read late where all is slow. ``variants`` names the
    sets of strengths that stand for one cause each (which sensor, which law); without them every strength alone, every
    two and all together are tried. A shape that no variant names belongs to all. ``laws`` are sets of parameters beside those: each is
    a law of its own, and none of its parameters is in another. What strengths that
    are ``averaged`` predict is a mean over jumps, about which the output is as far off as it is from the base. ``plays`` are half-widths
    of a play: from a narrow one a fit does not see what a wide one explains. ``knees`` are tensions at which a sensor's law changes: beyond all
    readings it would be another law. Friction that changes ``along`` a held line moves it, as far
    as it is elastic.
    """

    id: str
    title: str
    stage: str
    equation: str
    source: str
    parameters: tuple[Parameter, ...]
    excitation: str
    order: int = 50
    channel: str = "out"
    needs: tuple[str, ...] = ()
    systems: tuple[str, ...] = SYSTEMS
    fitted: bool = True
    look_alikes: tuple[str, ...] = ()
    variants: tuple[tuple[str, ...], ...] = ()
    laws: tuple[tuple[str, ...], ...] = ()
    averaged: tuple[str, ...] = ()
    plays: tuple[str, ...] = ()
    knees: tuple[str, ...] = ()
    law: Callable[[Law, Values], None] | None = None
    transition: Callable[[Transition, Values, Drive], None] | None = None
    output: Hook | None = None
    input: Hook | None = None
    input_inverse: Hook | None = None
    position: Callable[[Position, Values], None] | None = None
    loop: Callable[[Array, float, Values], Array] | None = None
    late_s: Callable[[str, Values], float] | None = None
    along: bool = False

    @property
    def stretches(self) -> bool:
        """Whether what it does goes with how far tendon and load give way."""
        return self.along or self.stage == TRANSITION

    @property
    def sought(self) -> bool:
        """Whether any of its laws is fitted."""
        return self.fitted or bool(self.laws)

    def parameter(self, name: str) -> Parameter:
        """Return a parameter by name; SstlError with the nearest name if there is none."""
        for p in self.parameters:
            if p.name == name:
                return p
        hint = nearest(name, [p.name for p in self.parameters])
        raise SstlError(f"effect {self.id} has no parameter '{name}' ({hint})", code="E701")

    def neutral(self) -> dict[str, float]:
        """Return the values at which the effect is exactly absent."""
        return {p.name: p.neutral for p in self.parameters}

    def complete(self, values: Values, usual: bool = False) -> dict[str, float]:
        """Return all parameter values, neutral where not given; SstlError where a value has no meaning.

        ``usual`` refuses values outside the catalogue's range too.
        """
        full = self.neutral()
        for name, value in values.items():
            p = self.parameter(name)
            # rigs of other sizes have other forces: of those only the side on which they have a meaning is fixed
            sized = p.unit in FORCE_UNITS and math.isfinite(value) and (p.least != p.neutral or value >= p.least)
            low, high = (p.low, p.high) if usual else (p.least, p.most)
            if (usual or not sized) and value != p.neutral and not low <= value <= high:
                near = low if value < low else high
                raise SstlError(
                    f"{self.id}: {name} = {value:g} {p.unit} is outside {low:g}..{high:g} {p.unit}",
                    fix=f"the nearest allowed is {near:g}, without the effect {p.neutral:g}: sstl effects show {self.id}",
                    code="E702",
                )
            full[name] = float(value)
        return full

    def active(self, values: Values) -> bool:
        """Whether any parameter that is not a mere shape differs from neutral."""
        return any(values.get(p.name, p.neutral) != p.neutral for p in self.parameters if not p.shape)


@dataclass
class Position:
    """Model of the proximal position built up by effects (compliances in mm/N, lengths in mm)."""

    length_mm: float = 2000.0
    tendon_mm_per_n: float = 0.0
    sheath_mm_per_n: float = 0.0
    creep_fraction: float = 0.0
    creep_s: float = 10.0
    creep_spread: float = 1.0
    cubic_per_mm2: float = 0.0
    play_mm: float = 0.0
    gap_mm: float = 0.0

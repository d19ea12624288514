"""What an effect of the rig of law variants declares, and what it may change: the parts before a run, the readings after it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.variant.laws import Chosen, Law
from sstl_cli.physics.variant.line import Array, Line, Rate, Rub, Spring
from sstl_cli.physics.variant.spec import VariantRun, VariantSpec

Values = Mapping[str, float]
# how much farther than the catalogue's the ranges of this rig reach
WIDER = 2.0


def wide(neutral: float, low: float, high: float) -> Bounds:
    """Return a strength's bounds, both ends `WIDER` times as far from neutral as the catalogue's, which are given."""
    return Bounds(neutral, neutral + WIDER * (low - neutral), neutral + WIDER * (high - neutral))


def positive(neutral: float, low: float, high: float) -> Bounds:
    """Return wider bounds of a time, length, force or speed, which must stay positive."""
    return Bounds(neutral, low / WIDER, high * WIDER)


@dataclass
class Parts:
    """The line as the cascade will see it, plain until effects change what is theirs; M stations, units mm, N, s.

    `length`, `bend` and `ends` (M,) are the shares of a pass in length, in the bend and at its two ends. `per_pass` is what a pass
    stretches (mm/N), `healing_mm` the slip over which a contact heals. `command` has a value a sample; `travels` give what is
    added to the position (mm) at these input tensions (N).
    """

    spec: VariantSpec
    run: VariantRun
    length: Array
    bend: Array
    ends: Array
    line: Line
    rub: Rub
    rate: Rate
    spring: Spring
    healing_mm: float
    command: Array
    per_pass: float = 0.0
    travels: list[Callable[[Array], Array]] = field(default_factory=list)

    def soften(self, per_pass: float) -> None:
        """Let a pass of tendon stretch by so much (mm/N), each segment by its length."""
        self.per_pass = per_pass
        half = 0.5 * per_pass * self.length
        self.line.compliance[:] = np.concatenate((half, [0.0])) + np.concatenate(([0.0], half))


@dataclass
class Reading:
    """What sensors and recorder make of one run, sample by sample: tensions (N), position (mm) and time stamps (s).

    `read_at` are the instants whose tension the output channel shows. The four generators are those of drifting zeros, of the
    recorder's clock, of a late channel and of faults.
    """

    system: str
    theta: float
    time: Array
    true_in: Array
    true_out: Array
    t_in: Array
    t_out: Array
    x: Array
    stamps: Array
    read_at: Array
    drift: np.random.Generator
    clock: np.random.Generator
    late: np.random.Generator
    faults: np.random.Generator


def unchanged(_part: Parts | Reading, _values: Values, _law: Chosen) -> None:
    """Leave everything as it is."""


@dataclass(frozen=True)
class Effect:
    """Laws and code of this rig for one effect, which at the neutral values of its parameters changes nothing.

    `build` changes the parts; `sense` the signals of the sensors, before their noise; `sample` when they are read; `store` what the
    converter and the recorder make of them. Effects act in their `order`.
    """

    parameters: Mapping[str, Bounds]
    laws: tuple[Law, ...]
    order: int = 50
    build: Callable[[Parts, Values, Chosen], None] = unchanged
    sense: Callable[[Reading, Values, Chosen], None] = unchanged
    sample: Callable[[Reading, Values, Chosen], None] = unchanged
    store: Callable[[Reading, Values, Chosen], None] = unchanged

"""The line as the cascade sees it: stations of friction, segments of tendon between them, the load behind.

Unknowns are tensions, not displacements. Station j turns the tension t before it into x behind it; a displacement is
what the segments behind it and the load have stretched. Units mm, N, s.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
REFERENCE_N = 10.0
# counters of a run
UNCONVERGED, SUBSTEPPED, ITERATIONS, WORK, LEAST = range(5)
# slow state of the whole line: run time (s), warmth, tension of the neighbours (N), factor on friction
CLOCK, WARMTH, BESIDE, FACTOR = range(4)


class Rub(NamedTuple):
    """Laws that follow the local tension: load, sheath, direction, pulley; without effects none does.

    A code is the place of the law among those of its effect.
    """

    pulley_pull: float = 0.0
    pulley_release: float = 0.0
    pulley_n: float = 0.0
    pulley_code: int = 0
    pulley_power: float = 1.0
    load: float = 0.0
    load_code: int = 0
    load_shape: float = 1.0
    sheath: float = 0.0
    sheath_code: int = 0
    sheath_shape: float = 1.0
    lean: float = 0.0
    lean_code: int = 0
    lean_shape: float = 1.0


class Rate(NamedTuple):
    """Laws that follow speed, displacement, rest and use."""

    memory_s: float
    weakening_mm: float
    drift: float = 0.0
    drift_code: int = 0
    drift_path: float = 1.0
    drift_shape: float = 1.0
    beside: float = 0.0
    beside_code: int = 0
    speed: float = 0.0
    speed_mm_s: float = 1.0
    speed_code: int = 0
    speed_shape: float = 1.0
    drag: float = 0.0
    drag_code: int = 0
    drag_shape: float = 1.0
    soft: float = 0.0
    soft_code: int = 0
    heal: float = 0.0
    heal_s: float = 1.0
    heal_code: int = 0
    heal_shape: float = 1.0
    dwell: float = 0.0
    dwell_s: float = 1.0
    dwell_code: int = 0
    dwell_shape: float = 1.0


class Spring(NamedTuple):
    """Laws of tendon and load."""

    load_k1: float
    plain: bool = False
    creep: float = 0.0
    fung: float = 0.0
    joint_share: float = 0.0
    joint_n: float = 1.5
    play: float = 0.0
    play_n: float = 1.0
    rope: float = 0.0
    rope_code: int = 0
    rope_shape: float = 1.0


class Laws(NamedTuple):
    """All laws in force."""

    rub: Rub
    rate: Rate
    spring: Spring


class Line(NamedTuple):
    """State of M stations and M + 1 segments; segment k ends at station k, the last one at the load."""

    angle: Array  # (M,) mu times bend angle
    weight: Array  # (M,) constant friction, N
    drag: Array  # (M,) N s/mm
    breakaway: Array  # (M,) mm, 0 for rigid
    pulley: Ints  # (M,) 1 at the pulley
    compliance: Array  # (M + 1,) mm/N
    tension: Array  # (M + 1,)
    crept: Array  # (M + 1, E) mm
    creep_share: Array  # (E,)
    creep_s: Array  # (E,)
    rope: Array  # (M + 1,) force between the wires, N
    joint: Array  # (2,) force of the hysteretic load (N), place in its play 0..1
    drop: Array  # (M,) friction at the last sample, N
    speed: Array  # (M,) remembered speed, mm/s
    rest: Array  # (M,) age of the contact, s
    wear: Array  # (M,) friction work over that of the run-in
    wear_n_mm: Array  # (M,)
    slow: Array  # (4,)
    tally: Array  # (5,)


class Trial(NamedTuple):
    """Work arrays of one step."""

    tension: Array  # (M + 1,)
    move: Array  # (M,) displacement in this step, mm
    angle: Array  # (M,) friction of the step: mu times bend angle
    weight: Array  # (M,) and constant friction, N
    share: Array  # (M,) what slip has left of the static excess
    offset: Array  # (M,) move = offset + tangent * tension behind
    tangent: Array  # (M,)
    force: Array  # (M,) friction and drag of the iterate
    slope: Array  # (M,) d force / d move
    gain: Array  # (M,) d force / d tension before
    moved: Array  # (M,) the move that force belongs to
    stuck: Ints  # (M,)
    flow: Array  # (M + 1,) creep of the step, mm, is give x tension - flow
    give: Array  # (M + 1,) mm/N

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
    """Laws that follow the local tension: load, sheath, direction, pulley. Codes as in `laws.LAWS`."""

    pulley_pull: float
    pulley_release: float
    pulley_n: float
    pulley_code: int
    pulley_power: float
    load: float
    load_code: int
    load_shape: float
    sheath: float
    sheath_code: int
    sheath_shape: float
    lean: float
    lean_code: int
    lean_shape: float


class Rate(NamedTuple):
    """Laws that follow speed, displacement, rest and use."""

    drift: float
    drift_code: int
    drift_path: float
    drift_shape: float
    beside: float
    beside_code: int
    speed: float
    speed_mm_s: float
    speed_code: int
    speed_shape: float
    drag: float
    drag_code: int
    drag_shape: float
    soft: float
    soft_code: int
    heal: float
    heal_s: float
    heal_code: int
    heal_shape: float
    dwell: float
    dwell_s: float
    dwell_code: int
    dwell_shape: float
    memory_s: float
    weakening_mm: float


class Spring(NamedTuple):
    """Laws of tendon and load."""

    plain: bool
    creep: float
    load_k1: float
    fung: float
    joint_share: float
    joint_n: float
    play: float
    play_n: float
    rope: float
    rope_code: int
    rope_shape: float


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

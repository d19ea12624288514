"""What is known of elastic lines as they are marched: rows of an array, one number to each lane (see lanes)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
FACTOR_NODES = 64
# rows of a node that are given: capstan angles (rad), forces without tension (N), drag (N s/mm), compliances (mm/N), pulley, and
# one over the way in which friction builds up (1/mm, 0 where there is none)
PHI_PULL, PHI_RELEASE, HOLD, DRAG, ELASTIC, CREEP, PULLEY_PULL, PULLEY_RELEASE, RIGID = range(9)
GIVEN = 9
# and those of its state: displacement now and at the knot before (mm), friction (N) and the tensions around it (N)
U, U_OLD, FORCE, FORCE_OLD, LEFT, AFTER = range(GIVEN, GIVEN + 6)
# share of the tension at which it slips, stiffness (N/mm), which way it goes, and compliance after creep
PULL, RELEASE, STIFF, VISCOUS, MODE, INVERSE, OFFSET, CREPT = range(GIVEN + 6, GIVEN + 14)
# Newton's step, and what laws with a memory remember
LOWER, STAY, RESIDUAL, SHARE, STEP, WENT, SPEED, EXCESS, AGE, FACTOR, CREPT_FAST, CREPT_SLOW = range(GIVEN + 14, GIVEN + 26)
FIELDS = GIVEN + 26
# rows of a line: numbers of its transition, the tension (N) that gives contacts the stiffness they keep (0: it goes with the tension
# before them), step of its table of factors (N); step before (s), and whether it has not ended
CREEP_S, CREEP_SPREAD, STATIC, STATIC_SPEED, AGING, AGING_S, STRIBECK, STRIBECK_SPEED, TAIL, BRISTLE_N, THINNING, FACTOR_STEP = range(12)
LAWS = 12
STEP_OLD, BUSY = LAWS, LAWS + 1


class Input(NamedTuple):
    """What goes into lines, end to end: line i has the samples ``edges[i]`` to ``edges[i + 1]`` of ``tension`` (N).

    ``knots`` count from its first sample, ``steps`` lead to them (s), ``scale`` on mu has one entry or one per sample.
    """

    tension: Array
    edges: Counts
    knots: Counts
    knot_edges: Counts
    steps: Array
    scale: Array


class Lines(NamedTuple):
    """Lines: ``given`` of shape (lines, GIVEN, nodes), ``laws`` (lines, LAWS), ``factors`` (lines, FACTOR_NODES).

    ``nodes`` says how many each has, ``start`` its output before the first sample (N).
    """

    nodes: Counts
    given: Array
    laws: Array
    factors: Array
    start: Array


class Kind(NamedTuple):
    """The laws that any of some lines has."""

    creeping: bool
    dragging: bool
    nonlinear: bool
    static: bool
    aging: bool
    moving: bool
    changing: bool
    smooth: bool
    thinning: bool
    spread: bool

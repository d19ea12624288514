"""Where a simulated line slides, how steeply, and where it breaks away: read off its answers to an input and to one that is shifted."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
# a shift of the input (N) that shows the slope of a line; no friction makes a line steeper than that
SHIFT_N = 1e-2
STEEPEST = 50.0
# from this share on a line follows more than it holds, below that one it is held: friction that drifts moves it, not its input
MOSTLY, HARDLY = 0.5, 0.01


class Grid(NamedTuple):
    """Records end to end: where each begins and ends at the rate of the simulation and at that of the analysis, and their ratio."""

    fine_edges: Counts
    edges: Counts
    factors: Counts


@njit(cache=True, nogil=True)
def phases_of(here: Array, moved: Array, u: Array, share: Array, grid: Grid, driven: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Return by which share the mean and the end of a step follow the input instead of what was held before, and gain, (samples,)."""
    fine_edges, edges, factors = grid
    slide, left, gain = np.empty(edges[-1]), np.empty(edges[-1]), np.empty(edges[-1])
    for i in range(factors.size):
        f, at, end = factors[i], fine_edges[i], fine_edges[i + 1]
        before = follows = 0.0
        for k in range(edges[i], edges[i + 1]):
            slopes = slides = sloping = slid = 0.0
            kept = 1.0
            for _ in range(f):
                slope = _slope(here[at], moved[at])
                # the first reading after a hold is on the slide altogether, however late since the last one that began
                now = 1.0 if follows > 0.0 and before == 0.0 else follows
                kept *= 1.0 - now
                slid += share[at] * (1.0 - kept)
                slopes += slope
                slides += now
                sloping += now * slope
                at += 1
                before, follows = follows, 0.0
                if at < end:
                    due = _slope(here[at], moved[at]) * abs(u[at] - u[at - 1])
                    follows = min(abs(here[at] - here[at - 1]) / due, 1.0) if due > 1e-12 else 0.0
                    follows = follows if follows > HARDLY else 0.0
            # a line that a motion drives slides all the time
            slide[k] = 1.0 if driven[i] else slid
            left[k] = 1.0 if driven[i] else 1.0 - kept
            gain[k] = slopes / f if driven[i] or slides == 0.0 else sloping / slides
    return slide, left, gain


@njit(cache=True, nogil=True)
def breakaways(
    here: Array,
    u: Array,
    share: Array,
    phases: tuple[Array, Array, Array],
    begins: tuple[Counts, Array],
    grid: Grid,
    driven: NDArray[np.bool_],
) -> Array:
    """Return by how much (N) a sliding line moves to the end of each step and on average, how far one that will lies beyond what is held, its gain.

    Shape (samples, 4); the first is NaN where a line neither slides nor holds until it does. It slides where it follows more than it
    holds. ``phases`` are slide, left and gain, ``begins`` the places (at the rate of the simulation) and outputs (N) of a model before
    its first sample: one that the input has elsewhere has broken away there.
    """
    slide, left, gain = phases
    begin, starts = begins
    fine_edges, edges, factors = grid
    out = np.zeros((edges[-1], 4))
    out[:, 0] = np.nan
    b, level = 0, 0.0
    for i in range(factors.size):
        ends = fine_edges[i] - 1 + factors[i] * np.arange(1, edges[i + 1] - edges[i] + 1)
        held, least = 0, np.inf
        for now in range(edges[i], edges[i + 1]):
            if left[now] > MOSTLY:
                least = min(least, gain[now])
        for k in range(ends.size):
            at, now = ends[k], edges[i] + k
            first = b < begin.size and begin[b] <= at
            while b < begin.size and begin[b] <= at:
                level, held, b = starts[b], k, b + 1
            average = np.sum(share[at + 1 - factors[i] : at + 1] * (here[at + 1 - factors[i] : at + 1] - level))
            moved, level = here[at] - level, here[at]
            # an elastic line answers its first input without sliding
            put = first and gain[now] > MOSTLY * least
            if left[now] == 0.0 and slide[now] == 0.0 and not put:
                continue
            if moved != 0.0 and math.isfinite(moved) and (left[now] > MOSTLY or put) and not driven[i]:
                out[now] = moved, average, 0.0, gain[now]
                for j in range(held, k):
                    # in the hold before it the line lies as far beyond as the input has to go
                    beyond = moved - gain[now] * (u[at] - u[ends[j]])
                    if beyond * moved < 0.0:
                        out[edges[i] + j] = 0.0, 0.0, beyond, gain[now]
            held = k + 1
    return out


@njit(cache=True, nogil=True)
def _slope(here: float, moved: float) -> float:
    slope = (moved - here) / SHIFT_N
    # no number where a fit asks for the absurd
    return min(max(slope, 0.0), STEEPEST) if slope == slope else 0.0

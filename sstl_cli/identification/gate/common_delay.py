"""A delay that all runs of a log share: two clocks that do not start together move every run alike, whatever a single one of them looks like."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.movement import unlike

# what a delay may leave of what friction alone and any other slip leaves, and of the output's span
LEAVES, LITTLE = 0.2, 0.05
# the slowest channel of the catalogue is that late (s), and a filter of so many samples
SHORTEST_S, SAMPLES = 0.2, 10.0
# runs that must tell a delay by themselves, and the part of it by which theirs differ: lines of friction take a part of a delay for their own
AGREE, ALIKE = 2, 0.15
# what one movement leaves of another one
ANOTHER = 0.5


def common_delay(log: Sequence[Evidence]) -> float:
    """Return the delay (s, negative where the output leads) with which alone friction explains the runs of a log, 0 where there is none.

    A movement that repeats looks turned, or given energy, where it is late by half a loop; one that does not repeat tells the delay.
    """
    runs = [e for e in log if e.tendon_like and e.loaded and not e.but_noise(1) and math.isfinite(e.causes.friction.rms_n)]
    if any(_in_time(e) for e in runs):
        return 0.0
    told = [e for e in runs if _needs(e)]
    if len(told) < AGREE or 2 * len(told) <= len(runs):
        return 0.0
    usual = median(e.causes.moved.size for e in max((_alike(o, told) for o in told), key=len))
    agree = [e for e in told if _agrees(e, usual)]
    plain = [e for e in agree if _agrees(e, usual, loops=False)]
    # two movements do not repeat after the same time
    apart = any(not unlike(plain[0].movement, e.movement) < ANOTHER for e in plain[1:])
    return usual if len(agree) == len(told) and apart else 0.0


def _alike(e: Evidence, told: Sequence[Evidence]) -> list[Evidence]:
    return [o for o in told if _agrees(o, e.causes.moved.size, loops=False)]


def _agrees(e: Evidence, usual: float, loops: bool = True) -> bool:
    """Whether a run is late by as much, or by a loop more or less, which a movement that repeats shows as well."""
    sizes = [e.causes.moved.size + k * e.loop_s for k in ((-1, 0, 1) if loops else (0,))]
    return min(abs(size - usual) for size in sizes) < ALIKE * abs(usual)


def _in_time(e: Evidence) -> bool:
    """Whether friction explains a run as it stands."""
    c = e.causes
    return c.enough or c.friction.rms_n < LITTLE * e.ranges[1].span


def _needs(e: Evidence) -> bool:
    """Whether a delay explains a run, and nothing else comes near."""
    c = e.causes
    rest = (c.friction, c.gain, c.zero_in, c.zero_out, c.slow, c.creep, c.speed, c.reversed)
    least = min(c.left(v.rms_n) for v in rest)
    far = abs(c.moved.size) > max(SHORTEST_S, SAMPLES * e.dt_s)
    return far and c.moved.rms_n < LITTLE * e.ranges[1].span and c.left(c.moved.rms_n) < LEAVES * least

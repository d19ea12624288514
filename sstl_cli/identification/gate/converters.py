"""What converters betray: the levels on which a channel's values lie are the same in every run of one rig and one calibration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence

# runs that must agree, their part of all, and relative difference of one converter's step in two runs
FEW, MOST, SAME = 2, 0.6, 0.02
# of the logarithm: a step that is another one; and how near to a whole multiple it may be one of an amplifier's ranges
OTHER, MULTIPLE = 0.1, 0.03
# of the logarithm: noise beside a step; step over noise from which on levels show, and steps that a channel must go through for them to show
NOISE = 0.25
SHOWN, THROUGH, LEAST_SAMPLES = 0.3, 20.0, 200


@dataclass(frozen=True)
class Odd:
    """Runs whose values of a channel lie on other levels than those of most: ``ratio`` of the steps, NaN where they lie between them."""

    runs: tuple[Evidence, ...]
    channel: int
    step_n: float
    ratio: float


def odd_levels(runs: Sequence[Evidence], i: int) -> list[Odd]:
    """Return the runs of one system whose channel ``i`` was converted otherwise than in most."""
    # the steps of a command are those of its movement
    shown = [e for e in runs if e.sensors[i].step_n > SHOWN * max(e.sensors[i].noise_n, 1e-300) and not e.sensors[i].computed]
    if len(shown) < FEW:
        return []
    steps = np.log([e.sensors[i].step_n for e in shown])
    order = np.sort(steps)
    usual = float(order[(len(order) - 1) // 2])
    same = [e for e, s in zip(shown, steps, strict=True) if abs(s - usual) < SAME]
    found = []
    if len(same) >= FEW and len(same) >= MOST * len(shown):
        apart = [(e, math.exp(s - usual)) for e, s in zip(shown, steps, strict=True) if abs(s - usual) > OTHER and not _multiple(s - usual)]
        found += [Odd((e,), i, math.exp(usual), ratio) for e, ratio in apart if _scaled(e, same, i, ratio)]
    between = tuple(e for e in runs if _between(e, i, math.exp(usual)))
    if len(same) >= FEW and len(same) == len(shown) and all(e.sensors[i].coarse for e in same) and between:
        found.append(Odd(between, i, math.exp(usual), math.nan))
    return found


def _scaled(e: Evidence, same: Sequence[Evidence], i: int, ratio: float) -> bool:
    """Whether the noise, where it shows, is scaled as the step is: fewer digits leave it as it was."""
    others = [o.sensors[i].noise_n for o in same if o.sensors[i].fine and o.sensors[i].noise_n > 0.0]
    mine = e.sensors[i]
    if not others or not mine.fine:
        # another gain leaves it as it was which of the two is the larger
        return not others and not mine.fine
    return abs(math.log(mine.noise_n / float(np.median(others)) / ratio)) < NOISE


def _multiple(log_ratio: float) -> bool:
    ratio = math.exp(abs(log_ratio))
    return abs(math.log(ratio / max(1, round(ratio)))) < MULTIPLE


def _between(e: Evidence, i: int, step: float) -> bool:
    """Whether a channel moves through many levels and shows none, but noise."""
    s = e.sensors[i]
    # levels show where as many of them are gone through as there are samples, and not more
    levels = e.ranges[i].span / step
    renewed = e.samples / s.stride
    return s.step_n == 0.0 and s.white and s.noise_n > 0.0 and renewed >= LEAST_SAMPLES and THROUGH < levels < renewed

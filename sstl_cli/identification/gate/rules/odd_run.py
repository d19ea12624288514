"""Runs unlike the others: one that stands alone, or two kinds that were put into one file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.converters import odd_levels
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.gain import alone
from sstl_cli.identification.gate.rules.two_rigs import second_rig
from sstl_cli.identification.gate.rules.zero import zeros
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "odd_run", 75
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Feature:
    """A property of rig and sensors that the movement does not change, and the gap (its unit) that counts."""

    name: str
    alone: float
    kinds: float
    ratio: bool


FEATURES = (
    Feature("noise of the input", math.log(1.7), math.log(1.5), True),
    Feature("noise of the output", math.log(1.7), math.log(1.5), True),
    Feature("gain of output over input", 0.25, 0.1, True),
    Feature("friction", 0.3, math.inf, True),
    Feature("zero of the input", 2.5, 2.0, False),
    Feature("zero of the output", 2.5, 2.0, False),
)
# gain of several runs beside others that have none (logarithms)
SEVERAL, NONE = Feature("gain of output over input", math.inf, math.log(1.15), True), 0.1
# step of a rounding over that of the other runs, and over their noise
FINER, LOST = 0.1, 3.0
FEW = 4
# what a law of friction may leave of what a zero leaves for the place where the lines meet to be the law's
LAW = 0.5
SMOOTHED = "it was probably smoothed or interpolated, or is no measurement"
RESENSED = "the sensor was probably changed or the file is from another rig"
# of the logarithm: noise below that of all other runs by which no other sensor of such a rig is the better one
QUIET = math.log(5.0)
# steps of the converter below which second differences are a few levels, and the noise of one sensor looks like another one from run to run
STEPS = 3.0
# noise below this part of the span is that of the arithmetic
ROUNDING = 1e-9
# noise of rounded numbers over that of the sensor in the other runs: a converter may hide it as well, but not so far below
NONE_LEFT = 0.02


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that lie apart from the rest of their system."""
    rigs = bool(second_rig(log)[0])
    # a gain makes a noise and a zero of its own
    told = alone(log)
    gained = _gained(log, told)
    told |= {e.run_id for e in gained}
    for system in sorted({e.system for e in log}):
        runs = [e for e in log if e.system == system and e.tendon_like and e.correlation > 0.0]
        yield from _levels(runs)
        runs = [e for e in runs if e.run_id not in told]
        if len(runs) < FEW:
            continue
        table = np.array([_values(e) for e in runs])
        splits = [(f, s) for j, f in enumerate(FEATURES) if (s := _split(table[:, j], f)) is not None]
        yield from _alone(runs, splits, rigs)
        yield from _kinds(runs, splits)
    for i in (0, 1):
        yield from _noise(log, i)
        yield from _digits(log, i)
        yield from _computed(log, i)
    yield from _gains(gained)


def _noise(log: Sequence[Evidence], i: int) -> Iterator[Remark]:
    """Yield the run whose sensor has another noise than in all other runs of the log, where that is the same in both systems."""
    runs = [e for e in log if e.usable and e.both_tensions]
    feature = FEATURES[i]
    values = np.array([_noise_of(e, i) for e in runs])
    split = _split(values, feature)
    if split is None or len(split.members) != 1 or split.gap < max(feature.alone, 3.0 * split.spread):
        return
    (index,) = split.members
    e = runs[index]
    others = [runs[j] for j in split.known if j != index]
    inside = [o for o in others if o.system == e.system and o.tendon_like]
    # what a system's runs tell among themselves is told there; noise that is not white may be the movement
    if split.spread > feature.kinds or not inside or (e.tendon_like and len(inside) >= FEW - 1) or not (split.below or e.sensors[i].white):
        return
    yield Remark(
        (e.run_id,), RULE, "remark", math.exp(split.gap), "1",
        f"{names([e.run_id])}: unlike all other runs, its {feature.name} {_far(feature, split)}; "
        f"{SMOOTHED if split.below else 'it is probably another sensor, or another quantity'}",
        "leave this file out, or take the column of the sensor",
    )  # fmt: skip


def _far(feature: Feature, split: _Split) -> str:
    """Return how far a run is from the others."""
    times = math.exp(split.gap)
    if not feature.ratio:
        return f"lies {split.gap:.3g} N from the nearest of them"
    return f"is {f'1/{times:.3g} of' if split.below else f'{times:.3g} times'} the nearest of them"


def _computed(log: Sequence[Evidence], i: int) -> Iterator[Remark]:
    """Yield runs whose values are smooth down to the rounding of their numbers, where the sensor shows its noise in all others."""
    runs = [e for e in log if e.usable and e.both_tensions and not e.sensors[i].held and e.hums[i] is None]
    hit = [e for e in runs if e.sensors[i].computed]
    rest = [e for e in runs if _shows(e, i) and e.sensors[i].fine]
    if not hit or len(rest) < max(FEW - 1, 2 * len(hit)) or not {e.system for e in hit} <= {e.system for e in rest}:
        return
    least = min(e.sensors[i].noise_n for e in rest)
    if max(e.sensors[i].rounding_n for e in hit) < NONE_LEFT * least:
        ids = tuple(e.run_id for e in hit)
        yield Remark(
            ids, RULE, "remark", least, "N",
            f"{names(ids)}: the {WORDS[i]} is smooth down to the rounding of its numbers, where it has {least:.2g} N of noise or more in the other runs; {SMOOTHED}",
            f"{CHANNELS[i]} = {{ column = ... }} (of this file exported anew, at the rate of the sensor)",
        )  # fmt: skip


def _digits(log: Sequence[Evidence], i: int) -> Iterator[Remark]:
    """Yield runs whose values were rounded to less than the sensor tells in the other runs."""
    runs = [e for e in log if e.usable]
    most = max((e.sensors[i].step_n for e in runs), default=0.0)
    fine = [e for e in runs if e.sensors[i].step_n < FINER * most]
    hit = [e for e in runs if e.sensors[i].step_n > 0.5 * most > 0.0]
    if len(fine) <= len(hit) or len(fine) + len(hit) < len(runs) or not {e.system for e in hit} <= {e.system for e in fine}:
        return
    noises = [e.sensors[i].noise_n for e in fine if e.sensors[i].white]
    if hit and len(noises) == len(fine) and most > LOST * float(np.median(noises)):
        ids = tuple(e.run_id for e in hit)
        yield Remark(
            ids, RULE, "remark", most, "N",
            f"{names(ids)}: the {WORDS[i]} stands on levels {most:.3g} N apart, where the sensor tells far less in the other runs; decimals were "
            "probably cut off when this file was written",
            f"{CHANNELS[i]} = {{ column = ... }} (of this file exported anew, with its decimals)",
        )  # fmt: skip


def _gained(log: Sequence[Evidence], told: set[str]) -> list[Evidence]:
    """Return several runs that have one gain, where the others, of the same systems, have none."""
    runs = [e for e in log if e.tendon_like and e.slopes.known and e.run_id not in told]
    split = _split(np.array([math.log(e.slopes.gain) for e in runs]), SEVERAL)
    if split is None or len(split.members) < 2 or split.gap < 3.0 * split.spread:
        return []
    hit = [runs[j] for j in sorted(split.members)]
    rest = [e for j, e in enumerate(runs) if j not in split.members]
    # a pulley makes a gain of its own in the loop
    none = abs(float(np.median([math.log(e.slopes.gain) for e in rest]))) < NONE
    return hit if none and {e.system for e in hit} == {e.system for e in rest} else []


def _gains(hit: Sequence[Evidence]) -> Iterator[Remark]:
    if hit:
        ids = tuple(e.run_id for e in hit)
        size = float(np.median([e.slopes.gain for e in hit]))
        yield Remark(
            ids, RULE, "remark", size, "1",
            f"{names(ids)}: the output reads {size:.3g} times what friction makes of it, in both systems, and in no other run; its sensor "
            "or amplifier was probably changed between the runs",
            _rescaled(1, size),
        )  # fmt: skip


def _levels(runs: list[Evidence]) -> Iterator[Remark]:
    """Yield runs whose values lie on other levels than those of the rest."""
    for i in (0, 1):
        for odd in odd_levels(runs, i):
            ids = tuple(e.run_id for e in odd.runs)
            between = math.isnan(odd.ratio)
            said = f"a step of {odd.step_n:.3g} N shows in the {WORDS[i]} of the other {runs[0].system} runs, "
            said += "and values between its levels in these" if between else f"and one {odd.ratio:.3g} times as large here"
            why = "they were probably recorded by another rig or resampled" if between else "its gain was probably another one"
            yield Remark(
                ids, RULE, "remark", odd.step_n if between else odd.ratio, "N" if between else "1",
                f"{names(ids)}: {said}; {why}",
                "import the two groups into logs of their own" if between else _rescaled(i, odd.ratio),
            )  # fmt: skip


def _rescaled(i: int, ratio: float) -> str:
    return f"{CHANNELS[i]} = {{ column = ..., scale = {1.0 / ratio:.4g} }} (for this file, if its gain was another one)"


def _values(e: Evidence) -> list[float]:
    s = e.slopes
    # of an output that goes one way two slopes are of one line, and friction is taken for a gain
    known = s.known and e.propagates_back
    gain = math.log(s.gain) if known else math.nan
    friction = math.log(s.friction) if known and s.friction > 0.05 else math.nan
    return [_noise_of(e, 0), _noise_of(e, 1), gain, friction, *(math.nan if _by_law(e, i) else at for i, at in enumerate(zeros(e)))]


def _by_law(e: Evidence, i: int) -> bool:
    """Whether friction that changes with speed, or fades, explains a run far better than a zero of this channel does: it moves the lines as well, and where they meet."""
    c = e.causes
    zero = c.left((c.zero_in, c.zero_out)[i].rms_n)
    return math.isfinite(zero) and min(c.left(c.speed.rms_n), c.left(c.fading.rms_n)) < LAW * zero


def _noise_of(e: Evidence, i: int) -> float:
    """Return the logarithm of a channel's noise, NaN where it does not show, or not to be compared with that of other runs."""
    s = e.sensors[i]
    return math.log(s.noise_n) if _shows(e, i) and s.noise_n > STEPS * s.step_n else math.nan


def _shows(e: Evidence, i: int) -> bool:
    """Whether a channel's noise shows; that of a program's numbers is the movement."""
    s = e.sensors[i]
    return s.noise_n > ROUNDING * e.ranges[i].span and s.step_n < s.noise_n and not s.held and e.hums[i] is None and not s.computed


@dataclass(frozen=True)
class _Split:
    """The smaller side of the widest gap of a feature, and whether it is the lower one."""

    members: frozenset[int]
    below: bool
    gap: float
    spread: float
    known: frozenset[int]


def _split(values: Array, feature: Feature) -> _Split | None:
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < FEW:
        return None
    order = known[np.argsort(values[known])]
    steps = np.diff(values[order])
    at = int(np.argmax(steps))
    low, high = order[: at + 1], order[at + 1 :]
    below = len(low) <= len(high)
    small = low if below else high
    spread = max(float(np.ptp(values[low])), float(np.ptp(values[high])))
    gap = float(steps[at])
    if gap < min(feature.alone, feature.kinds):
        return None
    return _Split(frozenset(small.tolist()), below, gap, spread, frozenset(known.tolist()))


def _alone(runs: list[Evidence], splits: list[tuple[Feature, _Split]], rigs: bool) -> Iterator[Remark]:
    told: set[int] = set()
    for feature, split in splits:
        if len(split.members) != 1 or split.gap < max(feature.alone, (1.5 if feature.name == "friction" else 3.0) * split.spread):
            continue
        (index,) = split.members
        if index in told:
            continue
        e = runs[index]
        if rigs and feature.name == "friction":
            continue
        bends = [runs[i].config_id for i in split.known if i != index]
        if feature.name == "friction" and e.config_id is not None and e.config_id not in bends:
            # another bend, not another rig
            continue
        told.add(index)
        yield Remark(
            (e.run_id,), RULE, "remark", math.exp(split.gap) if feature.ratio else split.gap, "1" if feature.ratio else "N",
            f"{names([e.run_id])}: unlike all other {e.system} runs, its {feature.name} {_far(feature, split)}; "
            f"{SMOOTHED if split.below and split.gap > QUIET and feature in FEATURES[:2] else RESENSED}",
            "leave this file out, or give it its own mapping (gain, offset)",
        )  # fmt: skip


def _kinds(runs: list[Evidence], splits: list[tuple[Feature, _Split]]) -> Iterator[Remark]:
    clear = [
        (f, s) for f, s in splits if len(s.members) > 1 and s.gap > max(f.kinds, 2.0 * s.spread) and len(s.known) == len(runs)
    ]  # fmt: skip
    for members in dict.fromkeys(s.members for _, s in clear):
        agree = [(f, s) for f, s in clear if s.members == members]
        strong = any(f.ratio and s.gap > math.log(2.0) and s.gap > 4.0 * s.spread for f, s in agree)
        # output sensors of one gain each, on the same bend in the same movement, need no second witness
        cells = [{(e.config_id, e.trajectory) for i, e in enumerate(runs) if (i in members) == side} for side in (True, False)]
        apart = any(f.name.startswith("gain") and s.gap > 6.0 * s.spread for f, s in agree)
        strong |= apart and len(members) >= 3 and bool(cells[0] & cells[1])
        if len(agree) < 2 and not strong:
            continue
        inside = {runs[i].trajectory for i in members}
        outside = {e.trajectory for i, e in enumerate(runs) if i not in members}
        if not inside & outside and None not in inside | outside:
            # another movement, not another rig
            continue
        feature, split = max(agree, key=lambda a: a[1].gap / max(a[1].spread, 1e-9))
        ids = tuple(runs[i].run_id for i in sorted(members))
        size = f"by a factor of {math.exp(split.gap):.3g}" if feature.ratio else f"by {split.gap:.3g} N"
        yield Remark(
            ids, RULE, "remark", math.exp(split.gap) if feature.ratio else split.gap, "1" if feature.ratio else "N",
            f"{names(ids)}: {' and '.join(f.name for f, _ in agree)} differ {size} from the other {runs[0].system} runs, which "
            "agree among themselves; two rigs (or two sensors) are probably in one file",
            "import the two groups into logs of their own",
        )  # fmt: skip
        return

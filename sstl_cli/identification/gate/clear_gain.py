"""Gains that leave nothing but noise: sizes that friction that is no play may hide are clear here, beside other runs or in all of them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from sstl_cli.identification.gate.causes import MORE, Cause
from sstl_cli.identification.gate.evidence import Evidence

# calibrations of both sensors are within 15 % of each other (0.85 to 1.15 in the catalogue), and the same in all runs of a rig
SENSORS = -math.log(0.85)
# friction against the way of the pull and of the release differs by 20 % of its mean at the most, which leaves a gain of that part of n theta
TURNED = 0.2
# a pulley in the loop takes up to a quarter in one direction alone: half of that is gain
PULLEY = 0.5 * math.log(1.25)
# of the logarithm: what gains of one sensor scatter by, and how much further from the rest one of them must be
SAME, STEP = 0.05, 0.12
# runs of one movement on one bend on either side of a gain that came between them, and standard errors of the gain that it is beyond
REPEATED, ERRORS = 2, 10.0
# part of the largest friction by which bends of one gain must differ, and times the scatter about two gains that is left about a line of gain over friction
DIFFERS, AS_LINE = 0.1, 3.0
# what a gain leaves of what friction leaves where it is plain
PLAIN = 0.15
# factor between the input's noises of two recorders
OTHER = 1.2
# part of the span that friction may leave of most runs for it to be compared with
LITTLE = 0.02
# times the noise that friction alone and with a zero leaves at the least where the gain leaves but noise
FAR = 6.0
# runs that must agree where all of them have the gain, and those that must have none beside one that has it
AGREE, BESIDE = 3, 2
# what a gain beside a zero may leave of what any other slip leaves; the gain from which on no rig's sensors, directions and pulley make it; and how far
# (logarithm) those of one scale are from each other where presliding hides the lines
ALONE, ODD, ABOUT = 0.5, 1.7, 0.2
# zeros of sound sensors go up to 2 N in the catalogue: beyond twice that (N), and a tenth of the span, it is another scale's
OFFSET_N, OFFSET_SHARE = 2.5, 0.1


def clear_gain(e: Evidence, usual_n: float = 0.0) -> float:
    """Return the logarithm of the gain of a run that is explained by friction and a gain alone, NaN where it is not.

    Explained is what leaves but noise, or no more than ``usual_n`` (N RMS), what friction leaves of runs like it: a line that creeps is no play to its noise.
    Of a run that friction alone explains it is the gain of its lines.
    """
    if not e.tendon_like or not e.slopes.known:
        return math.nan
    c, found = e.causes, math.log(e.slopes.gain)
    noise = max(c.noise_n, usual_n)
    if c.friction.rms_n <= MORE * noise:
        return found if abs(found) < SENSORS else math.nan
    others = (c.friction, c.zero_in, c.zero_out, c.reversed, c.fading)
    without = min(v.rms_n for v in others if math.isfinite(v.rms_n))
    exact = c.gain.rms_n <= MORE * noise and without > FAR * noise
    return c.gain.size if exact and abs(found - c.gain.size) < SAME else math.nan


def _known(log: Sequence[Evidence]) -> list[tuple[float, Evidence]]:
    """Return the runs whose gain is clear to what friction, with it or without, leaves of most runs of their system, with its logarithm."""
    left: dict[object, list[float]] = {}
    for e in log:
        if e.tendon_like and not math.isnan(e.causes.friction.rms_n):
            least = min(v for v in (e.causes.friction.rms_n, e.causes.gain.rms_n) if not math.isnan(v))
            left.setdefault((e.system, e.tendon), []).append(least / max(e.ranges[1].span, 1e-300))
    # one or two runs are none to compare with
    usual = {key: v if (v := float(np.median(shares))) < LITTLE else 0.0 for key, shares in left.items() if len(shares) > BESIDE}
    gains = ((clear_gain(e, usual.get((e.system, e.tendon), 0.0) * e.ranges[1].span), e) for e in log)
    return [(g, e) for g, e in gains if math.isfinite(g)]


def allowed(e: Evidence) -> float:
    """Return how far from 1 (logarithm) sensors, friction that differs by direction and the pulley of a loop put a gain together."""
    return SENSORS + TURNED * e.slopes.friction + (PULLEY if e.system == "sstl" else 0.0)


def clear_alone(log: Sequence[Evidence]) -> dict[str, float]:
    """Return the gains of single runs that stand alone, clear beyond doubt, where the other runs of the system agree on another one."""
    known = _known(log)
    found = {}
    for g, e in known:
        others = [(v, o) for v, o in known if o is not e and (o.system, o.tendon) == (e.system, e.tendon)]
        # what friction alone explains needs no gain: its lines are compared with, and accuse nobody
        if e.causes.enough or len(others) < BESIDE or max(v for v, _ in others) - min(v for v, _ in others) > SAME:
            continue
        # a direction that rubs more moves the gain with the friction
        by = max(STEP + TURNED * abs(e.slopes.friction - o.slopes.friction) for _, o in others)
        if min(abs(g - v) for v, _ in others) > by:
            found[e.run_id] = math.exp(g)
    return found


def clear_repeats(log: Sequence[Evidence]) -> dict[str, float]:
    """Return the gains of several runs of a system where they agree on one and the others on none, in repetitions of one movement on one bend as well,
    or on several bends that rub as differently as they like.
    """
    known = _known(log)
    found = {}
    for key in sorted({(e.system, e.tendon) for _, e in known}, key=str):
        runs = sorted(((g, e) for g, e in known if (e.system, e.tendon) == key), key=lambda v: v[0])
        apart = [b[0] - a[0] for a, b in pairwise(runs)]
        at = 1 + max(range(len(apart)), key=apart.__getitem__) if apart else 0
        rest, hit = sorted((runs[:at], runs[at:]), key=lambda side: abs(side[len(side) // 2][0]) if side else 0.0)
        if (
            _agree(rest)
            and _agree(hit)
            and _parted(rest, hit)
            and (_together(rest, hit) or _by_no_friction(rest, hit))
            and max(abs(g) for g, _ in rest) < SAME
            and not all(e.causes.enough for _, e in hit)
        ):
            found.update({e.run_id: math.exp(g) for g, e in hit})
    return found


def clear_some(log: Sequence[Evidence]) -> dict[str, float]:
    """Return the gains of runs that have another one than the rest: alone, several of them, and runs of their bends that tell the same less clearly."""
    alone, several = clear_alone(log), clear_repeats(log)
    found = {**several, **alone} if _one_gain([*several.values(), *alone.values()]) else alone or several
    if not found:
        return found
    usual = float(np.median(list(found.values())))
    bends = {(e.config_id, e.location, e.tendon) for e in log if e.run_id in found}
    beside = [e for e in log if e.run_id not in found and e.tendon_like and (e.config_id, e.location, e.tendon) in bends]
    for e in beside if len(found) >= REPEATED else []:
        if abs(e.causes.gain.size - math.log(usual)) < SAME and e.causes.holds(e.causes.gain.rms_n, PLAIN):
            found[e.run_id] = math.exp(e.causes.gain.size)
    return found


def _one_gain(gains: Sequence[float]) -> bool:
    return len(gains) > 0 and math.log(max(gains) / min(gains)) < SAME


def _agree(runs: Sequence[tuple[float, Evidence]]) -> bool:
    """Whether several runs have one gain."""
    return len(runs) >= REPEATED and runs[-1][0] - runs[0][0] < 0.5 * SAME


def _parted(rest: Sequence[tuple[float, Evidence]], hit: Sequence[tuple[float, Evidence]]) -> bool:
    """Whether two groups of runs differ in gain by more than their errors, and than a direction that rubs more moves it with the friction."""
    gap = min(abs(g - v) for g, _ in hit for v, _ in rest)
    rubs = max(abs(e.slopes.friction - o.slopes.friction) for _, e in hit for _, o in rest)
    return gap > max(STEP + TURNED * rubs, ERRORS * max(e.slopes.friction_se for _, e in (*rest, *hit)))


def _together(rest: Sequence[tuple[float, Evidence]], hit: Sequence[tuple[float, Evidence]]) -> bool:
    """Whether one movement on one bend was recorded again and again in both groups: neither movement nor bend makes the gain."""
    cells = [Counter((e.config_id, e.location, e.trajectory) for _, e in side) for side in (rest, hit)]
    return any(None not in (c[0], c[2]) and min(cells[0][c], cells[1][c]) >= REPEATED for c in cells[0])


def _by_no_friction(rest: Sequence[tuple[float, Evidence]], hit: Sequence[tuple[float, Evidence]]) -> bool:
    """Whether each of the two groups holds several bends whose friction differs, and their gains do not go with it but by the step between the groups.

    Release times pull is the square of a gain whatever the bend; a direction that rubs more makes it a part of the friction.
    """
    sides = [[(e.slopes.friction, g) for g, e in side] for side in (rest, hit)]
    several = all(len({(e.config_id, e.location) for _, e in side}) > 1 for side in (rest, hit))
    apart = [max(f for f, _ in side) - min(f for f, _ in side) for side in sides]
    if not several or min(apart) < DIFFERS * max(f for side in sides for f, _ in side):
        return False
    # a gain of the output leaves the input as noisy as it was: else the recorder is another one, and ``odd_run`` tells two rigs
    noises = [[e.sensors[0].noise_n for _, e in side] for side in (rest, hit)]
    if max(min(noises[0]) / max(*noises[1], 1e-300), min(noises[1]) / max(*noises[0], 1e-300)) > OTHER:
        return False
    friction, gains = (np.array([v[i] for side in sides for v in side]) for i in (0, 1))
    line = gains - np.polyval(np.polyfit(friction, gains, 1), friction)
    step = np.concatenate([np.array([g for _, g in side]) - float(np.mean([g for _, g in side])) for side in sides])
    floor = max(e.slopes.friction_se for _, e in (*rest, *hit))
    return float(np.std(line)) > AS_LINE * max(float(np.std(step)), floor)


def clear_everywhere(log: Sequence[Evidence]) -> dict[str, float]:
    """Return the gains of all runs where every run that tells has the same one, and no rig's sensors, directions and pulley make it."""
    known = [(g, e) for e in log if math.isfinite(g := clear_gain(e))]
    if len(known) < AGREE:
        return {}
    gains = sorted(g for g, _ in known)
    beyond = all(abs(g) > allowed(e) for g, e in known)
    if not beyond or gains[-1] - gains[0] > SAME:
        return {}
    usual = gains[len(gains) // 2]
    return {e.run_id: math.exp(usual) for e in log if e.tendon_like and not e.causes.enough}


@dataclass(frozen=True)
class Anew:
    """A channel (0: input, 1: output) that has a scale of its own: its gain, and what it reads at no tension."""

    channel: int
    gain: float
    zero: float


def scaled_anew(log: Sequence[Evidence]) -> dict[str, Anew]:
    """Return the runs one of whose channels has a gain and a zero of its own, with those that show the same less clearly: a scale is the sensor's.

    A zero that a sound sensor may have makes no scale of a gain, nor does it tell which of the channels has it.
    """
    found: dict[str, Anew] = {}
    for system, tendon in sorted({(e.system, e.tendon) for e in log}, key=str):
        sensed = [e for e in log if (e.system, e.tendon) == (system, tendon)]
        hit = [e for e in sensed if has_scale(e)]
        if not hit:
            continue
        # where a zero is small either channel may have the scale: all runs together tell
        channel = int(sum(math.log(e.causes.scale.rms_n / e.causes.scale_in.rms_n) for e in hit) <= 0.0)
        if sorted(_sound_zero(e, channel) for e in hit)[len(hit) // 2]:
            continue
        own = sorted(_gain_of(e, channel) for e in hit)
        hit = [e for e in sensed if e in hit or _shows(e, channel, own[len(own) // 2])]
        found.update({e.run_id: Anew(channel, math.exp(_gain_of(e, channel)), _scale(e, channel).zero_n) for e in hit})
    return found


def has_scale(e: Evidence) -> bool:
    """Whether a channel of a run has a gain and a zero of its own, as that of a transmitter has (0 to 10 V, 4 to 20 mA).

    Together they leave much less than each of them alone, and than any other slip, which all leave more than noise. What differs by no more than sensors, directions and a pulley do must
    leave but noise, and its zero be beyond that of sound sensors.
    """
    c = e.causes
    if not e.tendon_like or c.enough or not math.isfinite(c.scale.rms_n):
        return False
    channel = int(c.scale.rms_n <= c.scale_in.rms_n)
    mine = _scale(e, channel)
    rest = min(v.rms_n for v in (*c.slips, c.reversed) if math.isfinite(v.rms_n))
    if c.noise_alone(rest) or not (c.left(mine.rms_n) < ALONE * c.left(rest) and c.left(mine.rms_n) < LITTLE * e.ranges[1].span):
        return False
    if abs(mine.size) > math.log(ODD):
        return True
    exact = mine.rms_n < MORE * c.noise_n and rest > FAR * c.noise_n
    return exact and not _sound_zero(e, channel) and abs(mine.size) > SENSORS + TURNED * mine.wrap + PULLEY


def _scale(e: Evidence, channel: int) -> Cause:
    return e.causes.scale if channel else e.causes.scale_in


def _gain_of(e: Evidence, channel: int) -> float:
    """Return the logarithm of the gain that a channel has beside its zero."""
    return e.causes.scale.size if channel else -e.causes.scale_in.size


def _sound_zero(e: Evidence, channel: int) -> bool:
    """Whether what a channel reads at no tension is, in N, no more than that of sound sensors."""
    gain = math.exp(_gain_of(e, channel))
    return abs(_scale(e, channel).zero_n) <= max(OFFSET_N * gain, OFFSET_SHARE * e.ranges[channel].span)


def _shows(e: Evidence, channel: int, gain: float) -> bool:
    """Whether a run allows a scale that others show: with a gain of about that and a zero friction leaves much less than alone."""
    return e.tendon_like and abs(_gain_of(e, channel) - gain) < ABOUT and e.causes.holds(_scale(e, channel).rms_n)

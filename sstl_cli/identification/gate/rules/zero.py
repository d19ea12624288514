"""A zero that is off by more than sensors drift: tension below zero, or an output above its input while pulling."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from sstl_cli.identification.gate.causes import Cause
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.playfit import PlayFit
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.magnitude import IMPOSSIBLE_N
from sstl_cli.identification.gate.rules.sign import below
from sstl_cli.identification.gate.slopes import Slopes
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "zero", 40
# no sound zero reads so far below no tension, whatever moved it (N, and share of the wider span)
BELOW_N, SHARE = 1.0, 0.05
# zero offsets of 2 N on each of two sensors are in the catalogue;
# drag, delay and friction that falls with load open the lines at low tension: they then meet below zero
ABOVE_N, UNDER_N = 4.5, 8.0
SHARE_APART = 0.15
# how many times further than the other runs among themselves a run's lines lie from theirs, least part of the span that counts as such a scatter
# (sensors and friction differ by as much between movements), fewest others, and factor within which both lines move as one zero moves them
MOVED, SCATTER, FEWEST, ALIKE = 5.0, 0.005, 2, 2.0
# zeros of two sensors drift by that much alike (N)
PRELOAD_N = 1.0
# zeros are read off loops that lines explain
EXPLAINED = 0.985
# on a straight tube the lines hardly open, and where they meet is anywhere
LEAST_FRICTION = 0.2
# a zero that one run alone holds: size (N; the catalogue has 2 N) and share of the span, what it may leave of what friction leaves,
# of what any other slip leaves, and of the output's span
HELD_N, HELD_SHARE, TAKES, BEFORE, LITTLE = 2.5, 0.1, 0.25, 0.5, 0.03
# where the input goes below no tension (N) it is the input's zero, and friction that is no play may leave more
PUSHED_N, OTHERS, MORE = 1.0, 0.8, 0.08
# part of the input's span over which each of the free lines must be seen
SEEN = 0.2
# how far (share of the input's span) the lines may be drawn on
REACH = 0.5
# what friction with that zero must find of where the lines meet
SIZE = 0.5


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs in which a tendon pushes, or gives more than it is pulled with."""
    negative, zeroed = below(log)
    for i in (0, 1):
        hit = [e for e in log if e.run_id in zeroed and (e.run_id, i) in negative]
        if hit:
            lowest = min(e.ranges[i].low for e in hit)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", lowest, "N",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} is negative throughout (down to {lowest:.4g} N) and still rises "
                f"with the {WORDS[1 - i]}, but a tendon cannot push; its zero was probably taken under load",
                f"{CHANNELS[i]} = {{ column = ..., offset = (reading at no load) }}",
            )  # fmt: skip
    for i in (0, 1):
        hit = [e for e in log if _below(e, i) and e.run_id not in zeroed]
        if hit:
            lowest = min(e.ranges[i].low for e in hit)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "remark", lowest, "N",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} goes down to {lowest:.3g} N, but a tendon cannot push; its "
                "zero is probably wrong (tared under load, or AC-coupled), or it is no tension but a difference or a derivative",
                f"{CHANNELS[i]} = {{ column = ..., offset = (reading at no load) }}",
            )  # fmt: skip
    yield from _cut(log)
    yield from _creeping(log)
    held = {(e.run_id, i) for e in log for i in (0, 1) if e.run_id not in zeroed and not (_below(e, 0) or _below(e, 1)) and _held(e, i)}
    beside = _beside([e for e in log if e.run_id not in zeroed and not (_below(e, 0) or _below(e, 1))], held)
    yield from _told(log, held, beside)
    held |= beside
    for i in (0, 1):
        told = {name for name, _ in held}
        hit = [e for e in log if _apart(e, i) and not (_below(e, 0) or _below(e, 1)) and e.run_id not in told]
        if hit:
            worst = max((zeros(e)[i] for e in hit), key=abs)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "remark", worst, "N",
                f"{names([e.run_id for e in hit])}: the lines of pull and release meet where the {WORDS[i]} reads {worst:.3g} N, "
                "but friction vanishes at no tension; its zero is probably wrong",
                f"{CHANNELS[i]} = {{ column = ..., offset = (reading at no load, about {worst:.3g}) }}",
            )  # fmt: skip
    told = {e.run_id for e in log if _below(e, 0) or _below(e, 1) or _apart(e, 0) or _apart(e, 1)} | zeroed
    rest = [e for e in log if e.run_id not in told]
    for e, by in _both(rest):
        yield Remark(
            (e.run_id,), RULE, "remark", by, "N",
            f"{names([e.run_id])}: the lines of pull and release meet where both channels read {by:+.3g} N beside those of the other runs, "
            "as with one offset on both; both zeros were probably set anew (tared) before this run, or a preload was left in",
            f"{CHANNELS[0]} = {{ column = ..., offset = {by:.3g} }}; {CHANNELS[1]} = {{ column = ..., offset = {by:.3g} }} (for this file)",
        )  # fmt: skip
    for e, i, by in _moved(rest):
        yield Remark(
            (e.run_id,), RULE, "remark", by, "N",
            f"{names([e.run_id])}: both lines lie where a zero of the {WORDS[i]} {by:+.3g} N from that of the other runs moves them; it was "
            "probably set anew (tared) before this run",
            f"{CHANNELS[i]} = {{ column = ..., offset = {by:.3g} }} (for this file)",
        )  # fmt: skip


def _creeping(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that friction explains to the noise where the output's zero goes along the run, and nothing else comes near."""
    hit = [e for e in log if e.tendon_like and _creeps(e)]
    # slow friction looks like it, and is the rig's: then other runs show it
    hit = [e for e in hit if not any(o is not e and o.system == e.system and o not in hit and _some_creep(o) for o in log)]
    if hit:
        by = max((e.causes.creep.size for e in hit), key=abs)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", by, "N",
            f"{names([e.run_id for e in hit])}: friction explains the output only if its zero goes by {by:+.3g} N from the first sample to the last; the "
            "sensor was probably not warm yet, or its amplifier drifts",
            "none: record again with a warm sensor, or take the drift out before the import",
        )  # fmt: skip


def _creeps(e: Evidence) -> bool:
    c = e.causes
    if not (c.holds(c.creep.rms_n, TAKES) and c.noise_alone(c.creep.rms_n)):
        return False
    rest = min(c.left(v.rms_n) for v in (*c.slips, c.reversed) if v is not c.creep)
    return abs(c.creep.size) > max(HELD_N, HELD_SHARE * e.ranges[1].span) and c.left(c.creep.rms_n) < TAKES * rest


def _some_creep(e: Evidence) -> bool:
    return e.causes.holds(e.causes.creep.rms_n) and abs(e.causes.creep.size) > SIZE * HELD_N


def _cut(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output rests at its lowest where friction takes it further down."""
    hit = [(e, r) for e in log if e.tendon_like and (r := e.shapes.rest) is not None and r.where == "lowest"]
    if hit:
        r = max((r for _, r in hit), key=lambda v: v.moved_n)
        yield Remark(
            tuple(e.run_id for e, _ in hit), RULE, "remark", r.moved_n, "N",
            f"{names([e.run_id for e, _ in hit])}: the output does not fall below {r.level_n:.3g} N, where friction moves it by {r.moved_n:.3g} N; its zero was "
            "probably taken under load and what is below cut off, or the tendon is slack there",
            f"{CHANNELS[1]} = {{ column = (the reading before it was zeroed), offset = (reading at no load) }}",
        )  # fmt: skip


@dataclass(frozen=True)
class _Apart:
    """A run, the other ones of its system, and by how much its lines of pull and release lie from theirs (N, and how often their scatter)."""

    run: Evidence
    sensed: Sequence[Evidence]
    lines: Slopes | PlayFit
    pull: float
    release: float
    times: float


def _lines_apart(log: Sequence[Evidence]) -> Iterator[_Apart]:
    """Yield how far the lines of each run lie from those of the other runs of its system."""
    for system, tendon in sorted({(e.system, e.tendon) for e in log}, key=str):
        sensed = [e for e in log if (e.system, e.tendon) == (system, tendon) and e.tendon_like]
        seen = [e for e in sensed if _shows(e)]
        least = SCATTER * max((e.ranges[1].span for e in sensed), default=0.0)
        for e in sensed:
            lines = e.slopes if _shows(e) else _free_lines(e)
            if lines is None:
                continue
            others = np.array([(o.slopes.beta_p, o.slopes.beta_r) for o in seen if o is not e])
            if len(others) < FEWEST:
                continue
            usual = np.median(others, axis=0)
            scatter = np.maximum(np.max(np.abs(others - usual), axis=0), least)
            pull, release = lines.beta_p - float(usual[0]), lines.beta_r - float(usual[1])
            yield _Apart(e, sensed, lines, pull, release, abs(pull) / float(scatter[0]))


def _shows(e: Evidence) -> bool:
    return e.slopes.known and e.slopes.friction > LEAST_FRICTION


def _free_lines(e: Evidence) -> PlayFit | None:
    """Return lines that explain the output of a run whose phases do not show them."""
    p = e.play
    both = p is not None and p.explained > EXPLAINED and min(p.reaches) > SEEN and 0.0 < p.gamma_p < 1.0 < p.gamma_r
    return p if both and not e.slopes.known else None


def _both(log: Sequence[Evidence]) -> Iterator[tuple[Evidence, float]]:
    """Yield runs whose lines lie closer together than those of the other runs, as a preload on both channels moves them, and by how much (N).

    No friction does that: dry friction, drag and a delay move the lines apart. Friction that is less under load draws them together, and bends them: lines on
    which phases and play operator do not agree, and which leave more than noise, tell no preload.
    """
    for a in _lines_apart(log):
        s = a.lines
        straight = a.run.slopes.known or (a.run.play is not None and a.run.causes.noise_alone(a.run.play.rms_n))
        if a.times > MOVED and a.pull > 0.0 > a.release and straight:
            by = a.pull / (1.0 - s.gamma_p), a.release / (1.0 - s.gamma_r)
            if s.gamma_p < 1.0 < s.gamma_r and abs(math.log(by[0] / by[1])) < math.log(ALIKE) and min(by) > PRELOAD_N:
                yield a.run, 0.5 * (by[0] + by[1])


def _moved(log: Sequence[Evidence]) -> Iterator[tuple[Evidence, int, float]]:
    """Yield runs of which both lines lie apart from those of the other runs as a zero moves them, its channel and by how much (N)."""
    for a in _lines_apart(log):
        e, pull = a.run, a.pull
        # dry friction moves the two lines apart; a zero of the output both alike, one of the input each by its slope
        if a.times > MOVED and pull * a.release > 0.0 and e.slopes.known:
            apart = math.log(a.release / pull)
            i = int(abs(apart) < abs(apart - 2.0 * e.slopes.friction))
            by = pull if i else -pull / e.slopes.gamma_p
            if abs(apart if i else apart - 2.0 * e.slopes.friction) < math.log(ALIKE) and _needed(e, i, by, a.sensed):
                yield e, i, by


def _needed(e: Evidence, i: int, by: float, sensed: Sequence[Evidence]) -> bool:
    """Whether friction that builds up over a path needs that zero as well, beside the one that it finds in the other runs.

    Presliding, drag and a small part of a loop bend both lines to one side, and leave a zero that all runs share where it is.
    """
    if e.causes.enough or not e.causes.holds(_zero(e, i).rms_n):
        return False
    # where friction alone leaves but noise there is none
    others = np.nan_to_num([_zero(o, i).size for o in sensed if o is not e])
    own = _zero(e, i).size - float(np.median(others))
    return SIZE * abs(by) < math.copysign(own, own * by) < abs(by) / SIZE


def _zero(e: Evidence, i: int) -> Cause:
    return e.causes.zero_out if i else e.causes.zero_in


def _beside(log: Sequence[Evidence], held: set[tuple[str, int]]) -> set[tuple[str, int]]:
    """Return the runs of the same sensor that hold a zero like one that was told, each not as clearly by itself: a sensor is zeroed for many runs."""
    found = set()
    for i in (0, 1):
        for first in [e for e in log if (e.run_id, i) in held]:
            of = [e for e in log if (e.system, e.tendon) == (first.system, first.tendon) and (e.run_id, i) not in held]
            found |= {(e.run_id, i) for e in of if _like(e, i, _zero(first, i).size)}
    return found


def _like(e: Evidence, i: int, size: float) -> bool:
    """Whether a zero of this channel of about this size (N) takes most of what friction leaves of a run; another slip may take as much."""
    mine = _zero(e, i)
    near = SIZE * abs(size) < math.copysign(mine.size, mine.size * size) < abs(size) / SIZE
    return e.tendon_like and e.causes.holds(mine.rms_n) and near


def _told(log: Sequence[Evidence], held: set[tuple[str, int]], beside: set[tuple[str, int]]) -> Iterator[Remark]:
    """Yield runs that hold a zero, with those ``beside`` them that hold it less clearly: the size is that of the clear ones."""
    every = held | beside
    for i in (0, 1):
        sizes = sorted(_zero(e, i).size for e in log if (e.run_id, i) in held)
        hit = [e for e in log if (e.run_id, i) in every]
        if sizes:
            size = sizes[len(sizes) // 2]
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "remark", size, "N",
                f"{names([e.run_id for e in hit])}: friction explains the output only if the {WORDS[i]} reads {size:.3g} N at no "
                "tension; its zero was probably taken under load",
                f"{CHANNELS[i]} = {{ column = ..., offset = (reading at no load, about {size:.3g}) }}",
            )  # fmt: skip


def _held(e: Evidence, i: int) -> bool:
    """Whether the samples hold a zero of this channel: the lines of friction leave little with it, and much with any other slip."""
    c = e.causes
    mine, other = (c.zero_out, c.zero_in) if i else (c.zero_in, c.zero_out)
    if not e.tendon_like or not abs(mine.size) > max(HELD_N, HELD_SHARE * e.ranges[i].span):
        return False
    pushed = i == 0 and mine.size < 0.0 and e.ranges[0].low < -max(PUSHED_N, 5.0 * e.sensors[0].noise_n)
    if c.holds(mine.rms_n, TAKES) and mine.rms_n < (MORE if pushed else LITTLE) * e.ranges[1].span:
        rest = min(c.left(v.rms_n) for v in (other, c.gain, c.moved, c.reversed, c.speed))
        return c.left(mine.rms_n) < (OTHERS if pushed else BEFORE) * rest
    return False


def zeros(e: Evidence) -> tuple[float, float]:
    """Return the readings (N) of input and output at which pull and release meet: no tension, if friction is a share of it."""
    s = e.slopes
    if not s.known or s.friction < LEAST_FRICTION or (e.play is not None and e.play.explained < EXPLAINED):
        return math.nan, math.nan
    found = [_meet(s.gamma_p, s.beta_p, s.gamma_r, s.beta_r)]
    if e.play is not None and e.play.gamma_r > e.play.gamma_p:
        # an output that is late opens the lines; the play operator was fitted with its delay
        found.append(_meet(e.play.gamma_p, e.play.beta_p, e.play.gamma_r, e.play.beta_r))
    return min((x for x, _ in found), key=abs), min((y for _, y in found), key=abs)


def _meet(gamma_p: float, beta_p: float, gamma_r: float, beta_r: float) -> tuple[float, float]:
    at = (beta_p - beta_r) / (gamma_r - gamma_p)
    return at, beta_p + gamma_p * at


def _below(e: Evidence, i: int) -> bool:
    r = e.ranges[i]
    if not e.usable or not e.both_tensions or e.but_noise(i) or max(v.largest for v in e.ranges) > IMPOSSIBLE_N:
        return False
    # a sensor is off by a share of its range, which an output that friction holds back does not show
    return r.low < -max(BELOW_N, SHARE * max(v.span for v in e.ranges))


def _apart(e: Evidence, i: int) -> bool:
    if not e.tendon_like or e.causes.enough:
        return False
    at = zeros(e)[i]
    # lines that were seen only far from where they meet say little of it
    if e.ranges[0].low - zeros(e)[0] > REACH * e.ranges[0].span:
        return False
    # lines of presliding meet anywhere; a zero is off where friction needs it as well
    held = _zero(e, i)
    if not e.causes.holds(held.rms_n) or not SIZE * abs(at) < math.copysign(held.size, held.size * at) < abs(at) / SIZE:
        return False
    return abs(at) > max(ABOVE_N if at > 0.0 else UNDER_N, SHARE_APART * e.ranges[i].span)

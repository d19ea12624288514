"""Pull x release far from 1: input and output in different units, or through different levers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.clear_gain import Anew, clear_everywhere, clear_some, has_scale, scaled_anew
from sstl_cli.identification.gate.evidence import MOST_WRAP, Evidence
from sstl_cli.identification.gate.remark import Remark, Severity, names
from sstl_cli.identification.gate.rules.stuck import silent
from sstl_cli.identification.gate.units import FORCES, VOLTS, WORDS, force_unit, or_gain, stated

RULE, RANK = "gain", 28
# direction-dependent friction, pulleys and sensor gains of the catalogue together stay within
ODD, IMPOSSIBLE = 1.7, 3.0
# spread of one log: units are the same for all of its runs
ALIKE = 1.4
# of the logarithm: a gain that is odd in one run, and the part of it that all others stay within: what friction that is no play makes of them
SINGLE, WITHIN = 0.35, 0.29
# runs that tell a sensor's gain though others tell none, and their spread (logarithm)
AGREE, TOGETHER = 3, 0.1
# runs of which the gain is that of all others that do not tell theirs
BOTH = 2
# part of its span that an output must come back by to tell friction from a gain
BACK = 0.2
# logarithm of what middle levels may be off beyond friction
LEVELS = 0.4
# part of the largest output at which a line may meet no tension: one that meets more of it is part of a loop, no gain
MEETS = 0.35
# of the logarithm: noise (or range) of a channel beside that of the other runs
CHANGED = 0.4
# of the logarithm: error of a gain, at the least and at the most, within which a unit must fit to be named
FITS, FITS_MOST = 0.08, 0.12
# and from which on another gain is as likely as the unit
NEARLY = 0.045
# highest reading of a percentage: a range is chosen for what it must show, and passed by a little
LEAST_PERCENT, MOST_PERCENT = 20.0, 105.0
# what friction with a gain may leave of what friction alone and each zero leave, and of the output's span
TAKES, BEFORE, LITTLE = 0.15, 0.4, 0.02
# what a gain beside a zero may leave of what it leaves alone for its size to count
BESIDE_IT = 0.5
# part of what friction leaves that a gain must leave at the most
BARELY = 0.9
# of the logarithm: noise of the channel that is as in the other runs; part of what friction leaves that it may leave with a gain as the noise of the other channel tells it, and
# part of that gain to which friction must find it
AS_BEFORE, EXPLAINED, AGREES = 0.2, 0.5, 0.25


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output and input differ by a factor that friction does not make."""
    log = [e for e in log if not silent(e)]
    anew = scaled_anew(log)
    yield from _anew(log, anew)
    # a scale is the sensor's: a run of it that does not show it by friction has no other
    scaled = {(e.system, e.tendon) for e in log if e.run_id in anew}
    log = [e for e in log if e.run_id not in anew and ((e.system, e.tendon) not in scaled or _held(e))]
    sensed = _sensed(log)
    yield from (_of_noise(e, *how) for e, how in sensed)
    log = [e for e in log if all(e is not o for o, _ in sensed)]
    groups: dict[tuple[Severity, int], list[tuple[float, Evidence]]] = {}
    own = [(gain_of(e), e) for e in log]
    rig, both = _of_rig(own), _of_both_ways(own)
    gains = [(both if math.isfinite(both) and g > 0.0 and _one_line(e) else _adopted(g, e, rig), e) for g, e in own]
    usual = {system: _usual([g for g, e in gains if e.system == system]) for system in {e.system for e in log}}
    for g, e in gains:
        size = abs(math.log(g)) if g > 0.0 else math.nan
        if size > SINGLE and _others_fit(e, gains):
            # what friction that is no play makes of a gain is far less than what no rig has
            alone_as: Severity = "failure" if size > math.log(IMPOSSIBLE) else "remark"
            groups.setdefault((alone_as, round(math.log(g) / math.log(ALIKE) / 2.0)), []).append((g, e))
            continue
        # one run alone may be misled by a friction that is no play; a sensor is wrong in all
        if size < math.log(IMPOSSIBLE) and not abs(math.log(usual[e.system])) > math.log(ODD):
            continue
        if size > math.log(ODD):
            # one slip of all runs is told once, by what most of them show
            most = usual[e.system] if abs(math.log(g / usual[e.system])) < max(LEVELS, WITHIN * abs(math.log(usual[e.system]))) else g
            severity: Severity = "failure" if abs(math.log(most)) > math.log(IMPOSSIBLE) else "remark"
            groups.setdefault((severity, round(math.log(most) / math.log(ALIKE) / 2.0)), []).append((g, e))
    told = {e.run_id for hit in groups.values() for _, e in hit}
    yield from _clear([e for e in log if e.run_id not in told], bool(told or anew))
    for (severity, _), hit in groups.items():
        g = sorted(v for v, _ in hit)[len(hit) // 2]
        error = 2.0 * _error([v for v, _ in hit], hit[0][1])
        what, mend = _guess(g, hit[0][1], error)
        # another system may have other sensors
        rest = [e for v, e in gains if v > 0.0 and abs(math.log(v)) < SINGLE and e.system == hit[0][1].system]
        if rest:
            what, mend = _between(g, hit[0][1], rest, error)
        ids = _named(g, [e for _, e in hit], gains)
        yield Remark(
            ids, RULE, severity, g * g, "1",
            f"{names(ids)}: slope of pull times slope of release is {g * g:.3g} where friction gives 1, so output and input "
            f"differ by a factor of {g:.3g}; probably {what}",
            mend,
        )  # fmt: skip


def _sensed(log: Sequence[Evidence]) -> list[tuple[Evidence, tuple[int, float, float]]]:
    """Return the runs in which a gain scales the noise of one channel and its readings alike, though they show no lines: with the channel, and the gain (logarithm) by noise and by friction."""
    found = []
    for e in log:
        rest = [o for o in log if o is not e and o.system == e.system]
        c = e.causes
        if (
            not e.tendon_like
            or len(rest) < BOTH
            or math.isfinite(gain_of(e))
            or not c.left(c.gain.rms_n) < EXPLAINED * c.left(c.friction.rms_n)
        ):
            continue
        for i in (0, 1):
            by_noise, other = _noise_apart(e, rest, i), _noise_apart(e, rest, 1 - i)
            by_friction = c.gain.size if i else -c.gain.size
            if abs(by_noise) > math.log(ODD) and abs(other) < AS_BEFORE and abs(by_friction - by_noise) < AGREES * abs(by_noise):
                found.append((e, (i, by_noise, by_friction)))
    # few of a log, and not the kind that the others are
    return found if 2 * len(found) < len(log) else []


def _of_noise(e: Evidence, i: int, by_noise: float, by_friction: float) -> Remark:
    """Return what is said of a run one channel of which has a gain of its own."""
    factor = math.exp(by_noise)
    unit = force_unit(1.0 / factor, FITS)
    what = f"in {unit}, not N{or_gain(factor, e.ranges[i].high)}" if unit else f"in volts or at another gain ({factor:.3g} per N)"
    mend = stated(i, "counts", f", gain = {1.0 / factor:.4g}")
    return Remark(
        (e.run_id,), RULE, "failure" if abs(by_noise) > math.log(IMPOSSIBLE) else "remark", factor, "1",
        f"{names([e.run_id])}: the noise of the {WORDS[i]} is {factor:.3g} times that of the other runs, that of the {WORDS[1 - i]} is as there, and friction explains the output only with "
        f"a gain of the {WORDS[i]} of about {math.exp(by_friction):.2g}; the {WORDS[i]} is probably {what}",
        f"{stated(i, unit)} or {mend} (for this file)" if unit else f"{mend} (for this file)",
    )  # fmt: skip


def _named(g: float, hit: list[Evidence], gains: list[tuple[float, Evidence]]) -> tuple[str, ...]:
    """Return the runs that have a gain: where all runs that tell have it, those of their systems that do not tell as well, which friction alone does not explain."""
    told = {e.run_id for e in hit}
    alike = all(v > 0.0 and abs(math.log(v / g)) < SINGLE for v, _ in gains if v > 0.0)
    if len(hit) < BOTH or not alike:
        return tuple(e.run_id for e in hit)
    systems = {e.system for e in hit}
    return tuple(
        e.run_id
        for v, e in gains
        if e.run_id in told or (e.tendon_like and e.system in systems and not v > 0.0 and _allows(e, math.log(g)))
    )


def _allows(e: Evidence, size: float) -> bool:
    """Whether a run that does not tell a gain (logarithm) may have it: friction alone misses its output, or loses as much where it is hardly released."""
    return not e.causes.enough or (not e.slopes.known and size < 0.0 and e.causes.friction.wrap > -size)


def _clear(log: Sequence[Evidence], others: bool) -> Iterator[Remark]:
    """Yield gains that are small and leave nothing but noise; those of all runs where ``others`` have none of another size."""
    every = {} if others else clear_everywhere(log)
    found = every or clear_some(log)
    hit = [e for e in log if e.run_id in found]
    if not hit:
        return
    g = float(np.median(list(found.values())))
    ids = tuple(e.run_id for e in hit)
    what, mend = _between(g, hit[0], [e for e in log if e.run_id not in found and e.system == hit[0].system] or hit, 0.0)
    if every:
        what = "the calibration of one of the two is wrong, or it is in another unit"
        mend = f"{stated(1, 'counts', f', gain = {1.0 / g:.4g}')} or {stated(0, 'counts', f', gain = {g:.4g}')}"
    yield Remark(
        ids, RULE, "failure" if abs(math.log(g)) > math.log(IMPOSSIBLE) else "remark", g * g, "1",
        f"{names(ids)}: slope of pull times slope of release is {g * g:.3g} where friction gives 1{'' if every else ' and the other runs show it'}, so output and "
        f"input differ by a factor of {g:.3g}, which with friction leaves {'nothing but noise' if every else 'no more than in those'}; probably {what}",
        mend,
    )  # fmt: skip


def _anew(log: Sequence[Evidence], found: dict[str, Anew]) -> Iterator[Remark]:
    """Yield runs one of whose channels has a gain and a zero of its own, as the current or voltage of a transmitter has."""
    for i in (1, 0):
        hit = [e for e in log if e.run_id in found and found[e.run_id].channel == i]
        if not hit:
            continue
        g, zero = (float(np.median([getattr(found[e.run_id], name) for e in hit])) for name in ("gain", "zero"))
        ids = tuple(e.run_id for e in hit)
        product, unit = (g * g if i else 1.0 / (g * g)), force_unit(1.0 / g, FITS)
        named = f", or is in {unit} and its zero is off" if unit else ""
        yield Remark(
            ids, RULE, "failure" if abs(math.log(g)) > math.log(IMPOSSIBLE) else "remark", product, "1",
            f"{names(ids)}: slope of pull times slope of release is {product:.3g} where friction gives 1, and both lines meet where the {WORDS[1 - i]} reads nothing "
            f"and the {WORDS[i]} {zero:.3g}; the {WORDS[i]} probably has a gain of {g:.3g} and an offset of {zero:.3g}, as the mA (4 to 20) or V of a transmitter have, "
            f"and is not in N{named}",
            stated(i, "counts", f", gain = {1.0 / g:.4g}, offset = {zero:.3g}"),
        )  # fmt: skip


def _of_rig(gains: Sequence[tuple[float, Evidence]]) -> float:
    """Return the gain that all runs with lines of their own agree on, where it is none of friction; else NaN."""
    known = sorted(g for g, e in gains if e.slopes.known and g > 0.0)
    agree = len(known) >= AGREE and math.log(known[-1] / known[0]) < TOGETHER
    return known[len(known) // 2] if agree and abs(math.log(known[len(known) // 2])) > math.log(ODD) else math.nan


def _of_both_ways(gains: Sequence[tuple[float, Evidence]]) -> float:
    """Return the gain that the runs agree on whose output goes both ways, where it is none of friction; else NaN."""
    known = sorted(g for g, e in gains if g > 0.0 and not _one_line(e))
    agree = len(known) >= BOTH and math.log(known[-1] / known[0]) < TOGETHER
    return known[len(known) // 2] if agree and abs(math.log(known[len(known) // 2])) > math.log(ODD) else math.nan


def _one_line(e: Evidence) -> bool:
    """Whether an output hardly came back: on a pull friction and gain are one line, and any part of both explains it."""
    return not e.slopes.known and e.both_ways[1] < BACK


def _adopted(g: float, e: Evidence, rig: float) -> float:
    """Return the gain of a run, that of the rig where the run shows no lines of its own and allows it.

    Where an output is hardly released, a zero takes much of the gain, and the highest readings differ by what friction takes as well.
    """
    if e.slopes.known or math.isnan(rig) or not g > 0.0:
        return g
    if not _held(e):
        return rig if rig >= g else g
    low, high = sorted((e.causes.scale.size, e.causes.gain.size))
    return rig if low - LEVELS < math.log(rig) < high + LEVELS else g


def alone(log: Sequence[Evidence]) -> set[str]:
    """Return the names of runs whose gain stands alone among those of the others."""
    gains = [(gain_of(e), e) for e in log]
    return {e.run_id for g, e in gains if g > 0.0 and abs(math.log(g)) > SINGLE and _others_fit(e, gains)} | set(clear_some(log))


def _others_fit(e: Evidence, gains: list[tuple[float, Evidence]]) -> bool:
    """Whether this run's gain stands alone: that of all others, in its own movement as well, is far nearer to that of friction."""
    mine = next(abs(math.log(g)) for g, o in gains if o is e)
    others = [(abs(math.log(g)), o) for g, o in gains if o is not e and g > 0.0 and o.slopes.known]
    alike = [o for _, o in others if (o.system, o.trajectory) == (e.system, e.trajectory)]
    return len(others) >= 3 and bool(alike) and max(size for size, _ in others) < WITHIN * mine


def _usual(gains: list[float]) -> float:
    """Return the gain of most runs of a system; a run that does not tell speaks for none, unless several others agree."""
    known = sorted(g for g in gains if g > 0.0)
    if len(known) >= AGREE and math.log(known[-1] / known[0]) < TOGETHER:
        return known[len(known) // 2]
    every = sorted(g if g > 0.0 else 1.0 for g in gains)
    return every[len(every) // 2] if every else 1.0


def gain_of(e: Evidence) -> float:
    """Return the factor between output and input sensor, NaN where the run does not tell."""
    if not e.tendon_like or e.correlation < 0.2:
        return math.nan
    a, b = e.ranges
    top = b.high / max(a.high, 1e-300)
    g = e.slopes.gain
    if e.causes.enough:
        # friction alone leaves but noise
        return 1.0 if math.isfinite(g) else math.nan
    if _held(e) or has_scale(e):
        c = e.causes
        scale = min(c.scale, c.scale_in, key=lambda v: v.rms_n)
        # a zero that takes little beside a gain took it from friction
        return math.exp(scale.size if c.left(scale.rms_n) < BESIDE_IT * c.left(c.gain.rms_n) else c.gain.size)
    if not math.isfinite(g):
        # without slopes only the sizes speak: no output exceeds twice its input, none that moves is a hundredth
        moves = b.span > 20.0 * max(e.sensors[1].noise_n, e.sensors[1].step_n)
        return top if (top > 2.5 and not _let_go(e)) or (top < 0.02 and moves) else math.nan
    # slopes over a small part of the range say little of the gain: the sizes must agree
    if abs(math.log(g)) > math.log(ODD) and ((g > 1.0) != (top > (1.15 if g > 1.0 else 0.7)) or not _central(e, g) or not _from_nothing(e)):
        return math.nan
    return g


def _held(e: Evidence) -> bool:
    """Whether the samples hold a gain: friction leaves little with it, and much alone or with a zero."""
    c = e.causes
    rest = min(c.left(v.rms_n) for v in (c.zero_in, c.zero_out))
    best = c.holds(c.gain.rms_n, TAKES) and c.gain.rms_n < LITTLE * e.ranges[1].span
    return best and c.left(c.gain.rms_n) < BEFORE * rest and abs(c.gain.size) > math.log(ODD)


def _let_go(e: Evidence) -> bool:
    """Whether a run that is only released explains an output above its input: friction that a tube has leaves no more than a gain."""
    c = e.causes
    return c.friction.wrap < MOST_WRAP and not c.holds(c.gain.rms_n, BARELY)


def _from_nothing(e: Evidence) -> bool:
    """Whether the lines go to nothing with the tension, as a gain leaves those of friction; those of a part of a loop do not."""
    return max(abs(e.slopes.beta_p), abs(e.slopes.beta_r)) < MEETS * e.ranges[1].largest


def _central(e: Evidence, g: float) -> bool:
    """Whether the levels differ by the factor that the slopes do; in a small loop of presliding they do not."""
    a, b = (r.middle for r in e.ranges)
    return min(a, b) > 0.0 and abs(math.log(b / (g * a))) < e.slopes.friction + LEVELS


def _error(gains: list[float], e: Evidence) -> float:
    """Return the error of the logarithm of a gain: its spread over the runs, of one run alone what a zero makes of it or its slopes are known to."""
    if len(gains) > 1:
        logs = np.log(gains)
        return float(np.std(logs)) / math.sqrt(len(logs))
    if _held(e):
        return abs(e.causes.scale.size - e.causes.gain.size)
    return e.slopes.friction_se if e.slopes.known else FITS


def _guess(g: float, e: Evidence, error: float) -> tuple[str, str]:
    """Return what probably happened and the line that mends it; a unit is named where it fits the factor within its error."""
    within = min(max(FITS, error), FITS_MOST)
    options = []
    # sensors of 3 % each may move a unit by as much: another gain is then as likely
    off = {i: min(abs(math.log(f / size)) for size in FORCES.values()) for i, f in ((0, g), (1, 1.0 / g))}
    for channel, factor in ((0, g), (1, 1.0 / g)):
        unit = force_unit(factor, within)
        if unit is not None:
            # the unit must leave a tension that tendons bear
            size = abs(math.log(max(e.ranges[channel].largest * FORCES[unit], 1e-9) / 30.0))
            beside, line = (
                (", or has another gain (volts, a calibration)", f" or {stated(channel, 'counts', f', gain = {factor:.4g}')}")
                if off[channel] > NEARLY
                else ("", "")
            )
            percent = _percent(g, e) if beside else ""
            options.append((size, f"the {WORDS[channel]} is in {unit}, not N{beside}{percent}", f"{stated(channel, unit)}{line}"))
    if options:
        return min(options)[1:]
    small = 0 if g > 1.0 else 1
    # which of the two is off, the slopes cannot tell
    lines = {i: stated(i, "counts", f", gain = {f:.4g}") for i, f in ((0, g), (1, 1.0 / g))}
    if any(abs(math.log(g / ratio)) < within for ratio in (2.0, 0.5)):
        why = f"the {WORDS[1 - small]} is in percent of its range or doubled, or the {WORDS[small]} sensor reads half (2:1 pulley, one of a pair)"
        return why, f"{lines[1 - small]} or {lines[small]}"
    volts = "volts, or has another gain" if e.ranges[small].largest < VOLTS else "another unit, or has another gain"
    why = (
        f"the {WORDS[small]} is in {volts} (no unit of force fits {g:.3g}), or the {WORDS[1 - small]} is in counts or has a wrong calibration{_percent(g, e)}, "
        "or one of the two is no tension (the position of a line goes with it)"
    )
    return why, f"{lines[small]} or {lines[1 - small]}"


def _percent(g: float, e: Evidence) -> str:
    """Return what is said of a channel that reads more than the other one but never passes 100: it may be a percentage of its range."""
    large = 1 if g > 1.0 else 0
    high = e.ranges[large].high
    if not LEAST_PERCENT < high < MOST_PERCENT:
        return ""
    return f", or the {WORDS[large]} is in percent of a range of about {100.0 / max(g, 1.0 / g):.2g} N"


def _between(g: float, e: Evidence, rest: list[Evidence], error: float) -> tuple[str, str]:
    """Return what probably happened to one run of many, the others of whose system have no gain: one of its channels has changed.

    Its own noise, or its range in the same movement, tells which one; else both are named.
    """
    size = math.log(g)
    away = [_noise_apart(e, rest, i) for i in (0, 1)]
    if math.isnan(away[0]) or math.isnan(away[1]):
        same = [o for o in rest if o.trajectory == e.trajectory]
        away = [math.log(e.ranges[0].span / float(np.median([o.ranges[0].span for o in same]))), math.nan] if same else away
    inner, outer = away
    units = {i: force_unit(f, min(max(FITS, error), FITS_MOST)) for i, f in ((0, g), (1, 1.0 / g))}
    said = [
        f"the {WORDS[i]} is in {units[i]}, not N{or_gain(f, e.ranges[i].high)}"
        if units[i]
        else f"the {WORDS[i]} {'is in volts or ' if e.ranges[i].high < VOLTS else ''}has another gain"
        for i, f in ((0, 1.0 / g), (1, g))
    ]
    mends = [stated(i, units[i] or "counts", "" if units[i] else f", gain = {f:.4g}") for i, f in ((0, g), (1, 1.0 / g))]
    # a small gain changes the noise by as little
    off = min(CHANGED, 0.5 * abs(size))
    if abs(inner + size) < off and not abs(outer) > off:
        return said[0], mends[0]
    if abs(inner) < off and not abs(outer - size) > off:
        return said[1] if units[1] else f"the output was amplified {g:.3g} times as much as in the other runs", mends[1]
    small = f"{said[0]}, or {said[1] if units[1] else f'the output was amplified {g:.3g} times as much as in the other runs'}"
    return small, f"{mends[0]} or {mends[1]} (for this file)"


def _noise_apart(e: Evidence, rest: list[Evidence], i: int) -> float:
    """Return the logarithm of a channel's noise over that of the other runs, NaN where either does not show."""
    others = [o.sensors[i].noise_n for o in rest if o.sensors[i].fine and o.sensors[i].noise_n > 0.0]
    mine = e.sensors[i]
    return math.log(mine.noise_n / float(np.median(others))) if others and mine.fine and mine.noise_n > 0.0 else math.nan

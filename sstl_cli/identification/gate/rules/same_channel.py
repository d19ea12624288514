"""One reading taken twice: the output is a line of the input, noise and all, or to the noise where a bend must rub, or columns hold the same."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, column_line

RULE, RANK = "same_channel", 15
EXACT = 1e-6
# a channel that spans fewer times its noise than noise itself does has not moved: it is near any line
MOVED = 20.0
# what a line from input to output may leave, over the noise of both: friction that hides in noise adds less
HIDDEN = 1.2
# n theta of other runs of a bend that a run of it cannot lack, and what it takes from the usual tension, over the noise of both
RUBS, SHOWS = 0.05, 5.0
# part of the largest output at which the line of one tension may meet no input: sensors are zeroed to some percent, and within presliding an output
# begins at what it was left at
MEETS = 0.35
SAID = dict(
    time_s="the clock", tension_in_n="the input", tension_out_n="the output", position_in_mm="the position", tension_ref_n="the reference"
)

# a recorder may have written down the reference for the input, or the input for the reference: the latter spoils nothing
TRACKED = {CHANNELS[0], "tension_ref_n"}


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose channels share even their noise."""
    hit = [e for e in log if e.usable and _copy(e)]
    if hit:
        share = max(e.copy_rms for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", 100.0 * share, "%",
            f"{names([e.run_id for e in hit])}: the output is the input on a straight line to {100 * share:.2g} % of its "
            "span, noise included; one column was probably taken twice",
            column_line(1),
        )  # fmt: skip
    # nor is a line told by what has not moved: noise lies along any
    moved = [e for e in log if e.usable and all(r.span > MOVED * s.noise_n for r, s in zip(e.ranges, e.sensors, strict=True))]
    yield from _one_tension(moved)
    yield from _beside(moved)
    yield from _told(log)


def _one_tension(moved: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield all runs where none of them loses anything: a bend, or a second pass, that takes no friction is no tube.

    On one straight tube two sensors may agree; where there are several bends, or both systems, they cannot in all.
    """
    # what goes one way shows no loss, and does not speak against it
    tell = [e for e in moved if e.comes_back]
    several = len({e.config_id for e in tell}) > 1 or len({e.system for e in tell}) > 1
    if not several or not all(_lossless(e) for e in tell) or not all(_on_line(e) for e in moved) or any(_copy(e) for e in moved):
        return
    most = 100.0 * max(e.copy_rms for e in moved)
    ids = tuple(e.run_id for e in moved)
    yield Remark(
        ids, RULE, "remark", most, "%",
        f"{names(ids)}: the output follows the input on a straight line to {most:.2g} % of its span, the noise of the sensors, at every bend, so that "
        "nothing is lost to friction; both readings are probably of one tension, such as two sensors at the same end",
        column_line(1),
    )  # fmt: skip


def _beside(moved: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that lose nothing in a bend in which other runs, of either system, do."""
    # within the backlash presliding is a line
    free = [e for e in moved if e.wide and e.tendon_like and _lossless(e) and not _copy(e)]
    hit = [(e, lost) for e in free if (lost := e.passes * _rubs(e, [o for o in moved if o not in free])) > RUBS and _shows(e, lost)]
    if hit:
        ids = tuple(e.run_id for e, _ in hit)
        least = min(lost for _, lost in hit)
        yield Remark(
            ids, RULE, "remark", least, "1",
            f"{names(ids)}: nothing is lost to friction, where the other runs of the same bend tell n theta = {least:.2g}; both readings are probably of "
            "one tension, such as two sensors at the same end",
            column_line(1),
        )  # fmt: skip


def _rubs(e: Evidence, others: Sequence[Evidence]) -> float:
    """Return the least n theta of a pass that others tell of the bend of a run, NaN where none does."""
    where = (e.config_id, e.location, e.tendon)
    known = [o.wrap / o.passes for o in others if (o.config_id, o.location, o.tendon) == where and math.isfinite(o.wrap)]
    return min(known, default=math.nan) if e.config_id is not None else math.nan


def _shows(e: Evidence, wrap: float) -> bool:
    """Whether this friction would show behind the noise of both sensors."""
    return wrap * e.ranges[0].middle > SHOWS * math.hypot(*(s.noise_n for s in e.sensors))


def _lossless(e: Evidence) -> bool:
    """Whether a run that goes both ways follows one line, and that of one tension: it goes to nothing with it, that of presliding does not."""
    return e.comes_back and _on_line(e) and _from_nothing(e)


def _on_line(e: Evidence) -> bool:
    """Whether a straight line from input to output leaves no more than the noise of both sensors, and is none of friction."""
    if e.causes.enough and e.causes.friction.wrap > RUBS:
        # a run that is only pulled, or only released, goes along one line
        return False
    (u, y), span = (s.noise_n for s in e.sensors), e.ranges[1].span
    return 0.0 < e.copy_rms * span < HIDDEN * math.hypot(u * span / max(e.ranges[0].span, 1e-12), y)


def _from_nothing(e: Evidence) -> bool:
    """Whether the line through the extremes of both channels meets no tension near nothing, a zero of the sensors aside."""
    a, b = e.ranges
    slope = b.span / max(a.span, 1e-12)
    return abs(b.middle - slope * a.middle) < MEETS * b.largest


def _told(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield columns that hold the same numbers as another one, input and output (told above) left out."""
    pairs = {p for e in log for p in e.copies if p != CHANNELS}
    for a, b in sorted(pairs):
        hit = tuple(e.run_id for e in log if (a, b) in e.copies)
        command = "; if that is the command, the input is not what was measured" if {a, b} == TRACKED else ""
        # no tension is a length, and no output is what the input was asked for: whichever column is wrong, later rules would blame friction
        wrong = {a, b} != TRACKED and bool({a, b} & set(CHANNELS))
        yield Remark(
            hit, RULE, "failure" if wrong else "remark", 100.0, "%",
            f"{names(hit)}: {SAID[a]} and {SAID[b]} hold the same numbers, sample by sample, so that one column was probably taken twice{command}",
            f"{a} = {{ column = (the column of {SAID[a]}) }} or {b} = {{ column = (the column of {SAID[b]}) }}",
        )  # fmt: skip


def _copy(e: Evidence) -> bool:
    if e.copy_rms < EXACT:
        return True
    # two sensors on a straight tube agree to their noise, but not in it
    noise = e.sensors[1].noise_n
    span = e.ranges[1].span
    return e.noise_correlation > 0.8 and noise > 0.0 and e.copy_rms * span < 0.7 * noise < 0.7 * span / MOVED

"""One reading taken twice: the output is a line of the input, noise and all, or at every bend to the noise, or columns hold the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import hypot

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, column_line

RULE, RANK = "same_channel", 15
EXACT = 1e-6
# a channel that spans fewer times its noise than noise itself does has not moved: it is near any line
MOVED = 20.0
# what a line from input to output may leave, over the noise of both: friction that hides in noise adds less
HIDDEN = 1.2
SAID = dict(
    time_s="the clock", tension_in_n="the input", tension_out_n="the output", position_in_mm="the position", tension_ref_n="the reference"
)


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
    yield from _one_tension(log)
    yield from _told(log)


def _one_tension(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield all runs where none of them loses anything: a bend, or a second pass, that takes no friction is no tube.

    On one straight tube two sensors may agree; where there are several bends, or both systems, they cannot in all.
    """
    # nor is a line told by what has not moved: noise lies along any
    moved = [e for e in log if e.usable and all(r.span > MOVED * s.noise_n for r, s in zip(e.ranges, e.sensors, strict=True))]
    several = len({e.config_id for e in moved}) > 1 or len({e.system for e in moved}) > 1
    if not several or not all(_lossless(e) for e in moved) or any(_copy(e) for e in moved):
        return
    most = 100.0 * max(e.copy_rms for e in moved)
    ids = tuple(e.run_id for e in moved)
    yield Remark(
        ids, RULE, "remark", most, "%",
        f"{names(ids)}: the output follows the input on a straight line to {most:.2g} % of its span, the noise of the sensors, at every bend, so that "
        "nothing is lost to friction; both readings are probably of one tension, such as two sensors at the same end",
        column_line(1),
    )  # fmt: skip


def _lossless(e: Evidence) -> bool:
    """Whether a straight line from input to output leaves no more than the noise of both sensors."""
    (u, y), span = (s.noise_n for s in e.sensors), e.ranges[1].span
    return 0.0 < e.copy_rms * span < HIDDEN * hypot(u * span / max(e.ranges[0].span, 1e-12), y)


def _told(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield columns that hold the same numbers as another one, input and output (a failure of its own) left out."""
    pairs = {p for e in log for p in e.copies if p != CHANNELS}
    for a, b in sorted(pairs):
        hit = tuple(e.run_id for e in log if (a, b) in e.copies)
        command = "; if that is the command, the input is not what was measured" if {a, b} == {CHANNELS[0], "tension_ref_n"} else ""
        yield Remark(
            hit, RULE, "remark", 100.0, "%",
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

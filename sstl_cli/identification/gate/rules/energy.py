"""A hysteresis loop that runs the wrong way: friction would give energy instead of taking it, whatever its law."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.common_delay import common_delay
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.drift import drift_of
from sstl_cli.identification.gate.rules.unrelated import follows, unrelated
from sstl_cli.identification.gate.units import column_line

RULE, RANK = "energy", 49
# tension that a loop gives, in parts of the way of the input times the span of the output: friction takes 0.01 to 0.2 of it
GIVES = 0.02
# noises that an input must go for its loops to be a movement
MOVES = 20.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output is above on the way up and below on the way down."""
    hit = [
        e
        for e in log
        if e.usable
        and e.both_tensions
        and e.wide
        and e.loop_work > GIVES
        and _moves(e)
        and _passed_on(e)
        and follows(e)
        and not (unrelated(e) or drift_of(e))
    ]
    if hit and not common_delay(log):
        most = max(e.loop_work for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", 100.0 * most, "%",
            f"{names([e.run_id for e in hit])}: the hysteresis loop runs the wrong way, so that friction would give energy (by {100 * most:.2g} % of the way of "
            "both tensions); the output probably comes from another recording, runs backwards, was integrated or went through a high-pass (AC coupling), the input "
            "was filtered, or one of the two is a difference of both",
            column_line(1),
        )  # fmt: skip


def _moves(e: Evidence) -> bool:
    return e.ranges[0].span > MOVES * e.sensors[0].noise_n


def _passed_on(e: Evidence) -> bool:
    """Whether the output may be what its input passes on: what pushes by more than the input ever moves has a drive of its own, which gives what friction takes."""
    return not e.ranges[1].low < -e.ranges[0].span

"""A zero that jumps within a run: friction on both sides of one sample, with another zero behind it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "zero_change", 21
# a zero that creeps: least share of the span, and of N (sensors drift by less), what it may leave of what friction leaves, of what any other slip
# leaves, and of the span
CREEPS, CREEPS_N, TAKES, LESS, LITTLE = 0.12, 0.5, 0.25, 0.4, 0.04


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels reads more or less by one tension from one moment on."""
    for i in (0, 1):
        hit = [
            (e, c) for e in log if e.usable and e.both_tensions and (c := e.shapes.change) is not None and not c.is_gain and c.channel == i
        ]
        if hit:
            c = hit[0][1]
            yield Remark(
                tuple(e.run_id for e, _ in hit), RULE, "failure", c.size, "N",
                f"{names([e.run_id for e, _ in hit])}: from {c.at_s:.4g} s on the {WORDS[i]} reads {c.size:+.3g} N beside what friction makes "
                "of it before; its zero was probably set anew (tared) during the run",
                f"split the run there, and {CHANNELS[i]} = {{ column = ..., offset = {c.size:.3g} }} for the second part",
            )  # fmt: skip
    hit = [(e, e.causes.creep) for e in log if _creeps(e)]
    if hit:
        size = sorted((c.size for _, c in hit), key=abs)[len(hit) // 2]
        yield Remark(
            tuple(e.run_id for e, _ in hit), RULE, "remark", size, "N",
            f"{names([e.run_id for e, _ in hit])}: friction explains the output only if its zero creeps by {size:+.3g} N along the run; the sensor "
            "or its amplifier probably drifts",
            "none: record again once the sensor is warm, with readings at no load before and after",
        )  # fmt: skip


def _creeps(e: Evidence) -> bool:
    c = e.causes
    if not e.tendon_like or e.shapes.change is not None or not abs(c.creep.size) > max(CREEPS_N, CREEPS * e.ranges[1].span):
        return False
    rest = min(c.left(v.rms_n) for v in (c.gain, c.zero_in, c.zero_out, c.moved, c.slow, c.speed, c.reversed))
    return c.holds(c.creep.rms_n, TAKES) and c.left(c.creep.rms_n) < LESS * rest and c.creep.rms_n < LITTLE * e.ranges[1].span

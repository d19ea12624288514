"""A sensor at the end of its range: it rests at its extreme while the other channel goes on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.swapped import swapped
from sstl_cli.identification.gate.units import WORDS

RULE, RANK = "limit", 23
# what may be left of the misfit once the output is moved in time, or time is reversed
MOVED = 0.3


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels is cut off."""
    for i in (0, 1):
        if hit := limited(log, i):
            level = max(_level(e, i) for e in hit if math.isfinite(_level(e, i)))
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", level, "N",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} does not pass {level:.4g} N while the {WORDS[1 - i]} goes on rising; the "
                "sensor or its amplifier is probably saturated",
                "none: record again with more range, or cut out what lies at the limit",
            )  # fmt: skip


def limited(log: Sequence[Evidence], i: int) -> list[Evidence]:
    """Return the runs of which a channel is cut off: those that show it, and those of the same sensor that go to that level and no further.

    An input of the other system that ends at that very level is read by the same sensor; the outputs of both have sensors of their own.
    """
    if not any(_shows(e, i) for e in log):
        return []
    log = log if i else _sound_channels(log)
    shown = [(e.system, _level(e, i)) for e in log if _shows(e, i)]
    return [
        e for e in log if e.tendon_like and (_shows(e, i) or any(_ends_at(e, i, n) for system, n in shown if system == e.system or i == 0))
    ]


def _sound_channels(log: Sequence[Evidence]) -> Sequence[Evidence]:
    """Return the runs whose input may be cut off: an output in its place rests as well, at its largest in some of its runs, and exchanged channels explain all of them."""
    hit = swapped(log)
    rests = [e for e in hit if _shows(e, 0)]
    one = 2 * len(hit) > sum(e.usable for e in log) and 2 * len(rests) < len(hit)
    return [e for e in log if e not in hit] if one else log


def _shows(e: Evidence, i: int) -> bool:
    return e.tendon_like and math.isfinite(_level(e, i)) and not _elsewhen(e) and not (i and e.causes.enough)


def _ends_at(e: Evidence, i: int, level_n: float) -> bool:
    """Whether the highest readings of a channel are one level; those below it go on to it."""
    s = e.sensors[i]
    return abs(e.ranges[i].high - level_n) <= max(s.step_n, s.noise_n)


def _level(e: Evidence, i: int) -> float:
    """Return the level (N) that a channel does not pass, NaN where it shows none; an output may also rest there against friction."""
    r = e.shapes.rest
    # values that repeat against the noise are a stuck sensor's
    rests = i == 1 and r is not None and r.where == "highest" and e.sensors[1].still_share == 0.0
    return r.level_n if r is not None and rests else e.shapes.limit_n[i]


def _elsewhen(e: Evidence) -> bool:
    """Whether the output is but early or late, or the record runs backwards: then it rests while the input still goes on as well."""
    return any(e.causes.holds(c.rms_n, MOVED) for c in (e.causes.moved, e.causes.reversed))

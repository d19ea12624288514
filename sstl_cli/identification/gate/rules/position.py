"""A position in another unit than mm, with which the rig would be a thousand times too stiff or too soft, or one that counts the wrong way."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "position", 80
# rigs of 0.1 to 100 N/mm are known; EA of 10 kN over 2 m is 5 N/mm
STIFF, SOFT = 800.0, 0.02
# correlation of position and input in every run: an elastic line has +1, which hysteresis and creep lower, but do not turn
AGAINST = -0.5


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose tension over position no tendon has, or falls with it."""
    moved = [e for e in log if e.tendon_like and e.loaded and math.isfinite(e.position_follows)]
    if moved and max(e.position_follows for e in moved) < AGAINST:
        worst = max(e.position_follows for e in moved)
        yield Remark(
            tuple(e.run_id for e in moved), RULE, "remark", worst, "1",
            f"{names([e.run_id for e in moved])}: the tension falls as the position rises in every run (correlation {worst:.2f} or less), where "
            "a line that is pulled grows longer; the position probably counts the wrong way, or is that of the other end",
            "position_in_mm = { column = ..., sign = -1 }",
        )  # fmt: skip
    for stiff in (True, False):
        hit = [
            e
            for e in log
            if e.tendon_like and e.loaded and _stiffness(e) > 0.0 and (_stiffness(e) > STIFF if stiff else _stiffness(e) < SOFT)
        ]
        if hit:
            k = _stiffness(hit[0])
            unit = "m" if stiff else "um"
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "remark", k, "N/mm",
                f"{names([e.run_id for e in hit])}: tension over position is {k:.3g} N/mm, where tendons have 0.1 to 100; the "
                f"position is probably in {unit}, not mm",
                f'position_in_mm = {{ column = ..., unit = "{unit}" }}',
            )  # fmt: skip


def _stiffness(e: Evidence) -> float:
    return e.ranges[0].span / e.position_span_mm if e.position_span_mm > 0.0 else 0.0

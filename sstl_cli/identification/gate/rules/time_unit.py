"""Time in another unit than s: loops that last hours, or thousandths of a second."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.core.units import UNITS
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, Severity, names

RULE, RANK = "time_unit", 20
# a loop of a tendon takes 0.05 s (20 Hz) to minutes; quasi-static tests take an hour
SLOW_LOOP_S, SLOWEST_LOOP_S = 900.0, 3600.0
FAST_LOOP_S, FASTEST_LOOP_S = 0.05, 0.02
# nobody traces a loop with one sample a second, and load cells follow no faster than 100 kHz
SLOW_DT_S, SLOWEST_DT_S = 0.3, 0.9
FAST_DT_S, FASTEST_DT_S = 3e-5, 5e-6
# periods and their least (of seconds divided by a thousand: 10 kHz) that a clock in its right unit has
LEAST_DT_S, MOST_DT_S = (4e-5, 1e-4), 0.1
# sampling periods over the duration of a recording, beyond which its rows are not in order
ADDS_UP = 3.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose sampling period and loops are not those of a tension recording."""
    groups: dict[tuple[Severity, str], list[Evidence]] = {}
    for e in log:
        kind = _kind(e)
        if kind is not None:
            groups.setdefault(kind, []).append(e)
    for (severity, way), hit in groups.items():
        e = hit[0]
        index = way == "slow" and all(h.dt_s == 1.0 for h in hit)
        said, mend = ("a sample index", "time_s = { rate_hz = (samples a second) }") if index else _said(_units(e))
        yield Remark(
            tuple(h.run_id for h in hit), RULE, severity, e.dt_s, "s",
            f"{names([h.run_id for h in hit])}: a sample every {e.dt_s:.4g} s and a loop in {e.loop_s:.4g} s; time is "
            f"probably {said}",
            mend,
        )  # fmt: skip


def _kind(e: Evidence) -> tuple[Severity, str] | None:
    # rows out of order have no period: their steps do not add up
    if e.samples < 32 or not e.duration_s > 0.0 or not 0.0 < e.samples * e.dt_s < ADDS_UP * e.duration_s:
        return None
    # noise turns at any rate
    loops = e.loops and not e.but_noise(0)
    if e.dt_s > SLOWEST_DT_S or (e.loop_s > SLOWEST_LOOP_S and e.dt_s > 0.02):
        return "failure", "slow"
    if e.dt_s < FASTEST_DT_S or (loops and e.loop_s < FASTEST_LOOP_S):
        return "failure", "fast"
    if e.dt_s > SLOW_DT_S or (loops and e.loop_s > SLOW_LOOP_S):
        return "remark", "slow"
    if e.dt_s < FAST_DT_S or (loops and e.loop_s < FAST_LOOP_S):
        return "remark", "fast"
    return None


def _units(e: Evidence) -> list[str]:
    """Return the units of time in which period and loop would be usual, the most usual ones first; "s" for seconds divided by a thousand once too often."""
    sizes = {name: UNITS[name][1] for name in ("ms", "us", "ns", "min", "h")} | {"s": 1e3}
    fits = [
        n
        for n, size in sizes.items()
        if LEAST_DT_S[n == "s"] <= e.dt_s * size <= MOST_DT_S and FAST_LOOP_S <= e.loop_s * size <= SLOW_LOOP_S
    ]
    # halfway (in decades) between the ends of either range
    period, loop = (0.5 * math.log(a * b) for a, b in ((LEAST_DT_S[0], MOST_DT_S), (FAST_LOOP_S, SLOW_LOOP_S)))
    return sorted(fits, key=lambda n: (math.log(e.dt_s * sizes[n]) - period) ** 2 + (math.log(e.loop_s * sizes[n]) - loop) ** 2)


def _said(units: list[str]) -> tuple[str, str]:
    """Return what is said of the units that a clock may be in, and the lines that mend it."""
    if not units:
        return "in another unit than s", 'time_s = { column = ..., unit = "..." }'
    said = {n: f"in {n}, taken as s" for n in units} | {"s": "in s, divided by 1000 as if it were in ms"}
    scale = {n: f'unit = "{n}"' for n in units} | {"s": 'unit = "s" (not "ms"; or scale = 1000)'}
    return ", or ".join(said[n] for n in units), " or ".join(f"time_s = {{ column = ..., {scale[n]} }}" for n in units)

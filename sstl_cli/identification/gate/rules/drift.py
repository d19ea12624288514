"""A clock that drifts: the output's runs faster or slower than the input's, or the sampling period creeps."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.playfit import PlayFit
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "drift", 38
# a clock that is off by more is another rate, or no clock
FASTEST = 0.1
# share of the misfit that may remain: of a run alone, and of one with which others agree
REMAINS, AGREED = 0.5, 0.75
# misfit (share of the output's span) that presliding leaves of any play operator, and that a drift soaks up in part; what it leaves
# of friction over noise where nothing else is missing
PRESLIDING, NOTHING = 0.015, 1.3
CREEP, JITTER = 0.03, 7.0
# relative difference of one clock's drift in two runs
ALIKE = 0.25


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output moves away from its input in time."""
    shared = _shared(log)
    hit = [e for e in log if (drift_of(e) != 0.0 and e.loops > 1) or e.run_id in shared]
    if hit:
        worst = max((e.play.drift for e in hit if e.play is not None), key=abs)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", 100.0 * worst, "%",
            f"{names([e.run_id for e in hit])}: the output moves away from its input in time by {1000 * abs(worst):.3g} ms a "
            "second; one of the two clocks probably drifts",
            '[clocks] align = "apply" (with a column that both sides recorded as content)',
        )  # fmt: skip
    yield from _another_rate(log)
    # stamps that do not rise have no period
    hit = [e for e in log if e.usable and e.samples > 200 and _creeps(e)]
    if hit:
        worst = max((e.dt_last_s / e.dt_first_s - 1.0 for e in hit), key=abs)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", 100.0 * worst, "%",
            f"{names([e.run_id for e in hit])}: the sampling period changes by {100 * worst:.3g} % from the first to the last "
            "tenth of the run; the clock probably drifts",
            "time_s = { rate_hz = (samples a second) }",
        )  # fmt: skip


def _another_rate(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output's clock runs at a multiple of the input's."""
    hit = [(e.clock_rate.rate, e) for e in log if e.tendon_like and e.clock_rate is not None]
    for rate in sorted({r for r, _ in hit}):
        ids = tuple(e.run_id for r, e in hit if r == rate)
        times = f"{rate:.3g} times as fast as" if rate > 1.0 else f"{1.0 / rate:.3g} times more slowly than"
        yield Remark(
            ids, RULE, "remark", rate, "1",
            f"{names(ids)}: friction explains the output only if it runs {times} its input; the two channels were probably logged at "
            "different rates and put side by side row by row",
            f"tension_out_n = {{ column = ..., time = (its own clock, or row numbers), time_scale = {rate:.3g} times that of the input }}",
        )  # fmt: skip


def _creeps(e: Evidence) -> bool:
    """Whether the sampling period changes along the run by more than its jitter."""
    change = abs(e.dt_last_s - e.dt_first_s)
    return abs(e.dt_last_s / e.dt_first_s - 1.0) > CREEP and change > JITTER * e.dt_error_s


def _shared(log: Sequence[Evidence]) -> set[str]:
    """Return runs beside which others of the system drift alike: one loop alone may be misled by its own shape."""
    systems: dict[str, list[tuple[float, str]]] = {}
    for e in log:
        if (d := drift_of(e, AGREED)) != 0.0:
            systems.setdefault(e.system, []).append((d, e.run_id))
    found = set()
    for runs in systems.values():
        runs.sort()
        for (a, first), (b, second) in pairwise(runs):
            if abs(a - b) < ALIKE * min(abs(a), abs(b)):
                found |= {first, second}
    return found


def drift_of(e: Evidence, remains: float = REMAINS) -> float:
    """Return the drift of the output's clock (s/s), 0 where there is none to be seen."""
    p = e.play
    if not e.tendon_like or not e.wide or p is None or not _explained(p) > 0.95 or not 0.0 < p.gamma_p < p.gamma_r:
        return 0.0
    moved = abs(p.drift) * e.duration_s
    # what the noise of both sensors leaves is left by any clock
    noise = math.hypot(e.sensors[1].noise_n, p.gamma_p * e.sensors[0].noise_n)
    before, after = (math.sqrt(max(v**2 - noise**2, 0.0)) for v in (min(p.rms_n, p.delayed_rms_n), p.drifting_rms_n))
    if before < PRESLIDING * e.ranges[1].span and not e.causes.moved.rms_n < NOTHING * e.causes.noise_n:
        return 0.0
    clear = after < remains * before and 8.0 * p.drift_se < abs(p.drift) < FASTEST
    seen = clear and moved > max(0.1, 10.0 * max(e.dt_s, e.sensors[1].refresh_s))
    return p.drift if seen else 0.0


def _explained(p: PlayFit) -> float:
    """Return the share of the output's variance that lines, delay and drift explain; without the drift much may be left."""
    before = max(min(p.rms_n, p.delayed_rms_n), 1e-300)
    return 1.0 - (1.0 - p.explained) * min(1.0, p.drifting_rms_n / before) ** 2

"""A clock that drifts: the output's runs faster or slower than the input's, or the sampling period creeps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "drift", 38
REMAINS = 0.5
CREEP = 0.03
# relative difference of one clock's drift in two runs
ALIKE = 0.25


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output moves away from its input in time."""
    hit = [e for e in log if drift_of(e) != 0.0 and (e.loops > 1 or _shared(e, log))]
    if hit:
        worst = max((e.play.drift for e in hit if e.play is not None), key=abs)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", 100.0 * worst, "%",
            f"{names([e.run_id for e in hit])}: the output moves away from its input in time by {1000 * abs(worst):.3g} ms a "
            "second; one of the two clocks probably drifts",
            '[clocks] align = "apply" (with a column that both sides recorded as content)',
        )  # fmt: skip
    hit = [e for e in log if e.samples > 200 and abs(e.dt_last_s / e.dt_first_s - 1.0) > CREEP]
    if hit:
        worst = max((e.dt_last_s / e.dt_first_s - 1.0 for e in hit), key=abs)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", 100.0 * worst, "%",
            f"{names([e.run_id for e in hit])}: the sampling period changes by {100 * worst:.3g} % from the first to the last "
            "tenth of the run; the clock probably drifts",
            "time_s = { rate_hz = (samples a second) }",
        )  # fmt: skip


def _shared(e: Evidence, log: Sequence[Evidence]) -> bool:
    """Whether other runs of the system drift alike: one loop alone may be misled by its own shape."""
    others = [d for o in log if o is not e and o.system == e.system and (d := drift_of(o)) != 0.0]
    return any(abs(d / drift_of(e) - 1.0) < ALIKE for d in others)


def drift_of(e: Evidence) -> float:
    """Return the drift of the output's clock (s/s), 0 where there is none to be seen."""
    p = e.play
    if not e.tendon_like or p is None or not p.explained > 0.95 or not 0.0 < p.gamma_p < p.gamma_r:
        return 0.0
    moved = abs(p.drift) * e.duration_s
    seen = (
        p.drifting_rms_n < REMAINS * min(p.rms_n, p.delayed_rms_n)
        and abs(p.drift) > 8.0 * p.drift_se
        and moved > max(0.1, 10.0 * max(e.dt_s, e.sensors[1].refresh_s))
    )
    return p.drift if seen else 0.0

"""A sensor that stands still while the other one moves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from sstl_cli.identification.gate.evidence import MOST_WRAP, Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS, column_line

RULE, RANK = "stuck", 45
# behind a coarse converter backlash rests as well, but not over the whole loop
LEAST_S, LEAST_SHARE, LEAST_MOVED, WHOLE_MOVED = 0.5, 0.01, 0.2, 0.97
FAILED_SHARE = 0.1
# a shorter record may end before a slow sensor is renewed; one that saw the tension go is long enough
WHOLE_S, SHORT_S, WHOLE_SAMPLES = 2.0, 0.5, 200
# no backlash reaches down to this part of the tension pulled with
NEAR_ZERO = 0.05


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels repeats one value for long, or always."""
    yield from _together(log)
    for i in (0, 1):
        coarse: dict[str, float] = {}
        for o in log:
            if o.usable and (o.sensors[i].coarse or o.sensors[i].noise_n == 0.0):
                coarse[o.system] = max(o.sensors[i].step_n, coarse.get(o.system, 0.0))
        whole = [e for e in log if _whole(e, i) and not _hidden(e, i, coarse)]
        if whole:
            yield Remark(
                tuple(e.run_id for e in whole), RULE, "failure", 100.0, "%",
                f"{names([e.run_id for e in whole])}: the {WORDS[i]} never changes; the sensor is probably off or the wrong "
                "column was taken",
                column_line(i),
            )  # fmt: skip
        for severity in ("failure", "remark"):
            hit = [e for e in log if _stuck(e, i) == severity]
            if hit:
                e = max(hit, key=lambda h: h.sensors[i].still_s)
                s = e.sensors[i]
                yield Remark(
                    tuple(h.run_id for h in hit), RULE, severity, s.still_s, "s",
                    f"{names([h.run_id for h in hit])}: the {WORDS[i]} repeats one value for {s.still_s:.3g} s from "
                    f"{s.still_at_s:.4g} s on while the other channel moves by {e.stuck_while_n[i]:.3g} N; the sensor is "
                    "probably stuck",
                    f'skip this stretch, or {CHANNELS[i]} = {{ column = (another sensor) }}',
                )  # fmt: skip
        yield from _silent(log, i)
    yield from _against(log)


def _silent(log: Sequence[Evidence], i: int) -> Iterator[Remark]:
    """Yield runs one of whose channels loses its noise for a while and comes back elsewhere, whatever the other one does: in backlash that rests as well."""
    hit = [e for e in log if _lost_noise(e, i)]
    if hit:
        e = max(hit, key=lambda h: h.sensors[i].still_s)
        s = e.sensors[i]
        yield Remark(
            tuple(h.run_id for h in hit), RULE, "remark", s.still_s, "s",
            f"{names([h.run_id for h in hit])}: the {WORDS[i]} repeats one value for {s.still_s:.3g} s from {s.still_at_s:.4g} s on, where it has noise of "
            f"{s.noise_n:.2g} N all the rest of the time, and goes on elsewhere with a jump; the sensor was probably stuck, or its last value filled in",
            f'skip this stretch, or {CHANNELS[i]} = {{ column = (another sensor) }}',
        )  # fmt: skip


def _lost_noise(e: Evidence, i: int) -> bool:
    """Whether a channel that always has its noise repeats one value for a while, and jumps away from it."""
    s = e.sensors[i]
    lasts = s.still_s >= LEAST_S and LEAST_SHARE <= s.still_share < 1.0
    return e.usable and lasts and s.fine and s.restless and s.still_left and not _stuck(e, i) and not _paused(e)


def _against(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output rests, between its extremes, where friction moves it."""
    for severity in ("failure", "remark"):
        hit = [(e, r) for e in log if (r := e.shapes.rest) is not None and r.where == "between" and _resting(e, r.share) == severity]
        if hit:
            r = max((r for _, r in hit), key=lambda v: v.length_s)
            yield Remark(
                tuple(e.run_id for e, _ in hit), RULE, severity, r.length_s, "s",
                f"{names([e.run_id for e, _ in hit])}: the output rests at {r.level_n:.3g} N for {r.length_s:.3g} s from {r.at_s:.4g} s on, where friction, as "
                f"it is in the rest of the run, moves it by {r.moved_n:.3g} N; the sensor is probably stuck or was filled with its last value",
                "skip this stretch, or tension_out_n = { column = (another sensor) }",
            )  # fmt: skip


def _resting(e: Evidence, share: float) -> str:
    """Return how much it matters that an output rests against friction, nothing where its repeated values tell it already."""
    if not e.tendon_like or _stuck(e, 1):
        return ""
    return "failure" if share > FAILED_SHARE else "remark"


def _together(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs both channels of which repeat their values at the same time, against the noise of both: the recorder stood still."""
    for severity in ("failure", "remark"):
        hit = [e for e in log if _paused(e) == severity]
        if hit:
            e = max(hit, key=lambda h: h.sensors[0].still_s)
            s = e.sensors[0]
            yield Remark(
                tuple(h.run_id for h in hit), RULE, severity, s.still_s, "s",
                f"{names([h.run_id for h in hit])}: input and output both repeat one value for {s.still_s:.3g} s from {s.still_at_s:.4g} s on, "
                f"against noise of {s.noise_n:.2g} and {e.sensors[1].noise_n:.2g} N; the recorder probably stood still",
                "split the run there, or skip this stretch",
            )  # fmt: skip


def _paused(e: Evidence) -> str:
    a, b = e.sensors
    both = e.usable and a.fine and b.fine and min(a.still_s, b.still_s) >= LEAST_S and max(a.still_share, b.still_share) < 1.0
    # renewals of two channels need not fall on one sample
    if not both or abs(a.still_at_s - b.still_at_s) > 0.1 * a.still_s or abs(a.still_s - b.still_s) > 0.1 * a.still_s:
        return ""
    return "failure" if min(a.still_share, b.still_share) > FAILED_SHARE else "remark"


def _whole(e: Evidence, i: int) -> bool:
    s = e.sensors[i]
    other = e.ranges[1 - i]
    least = SHORT_S if other.low < NEAR_ZERO * other.high else WHOLE_S
    return s.still_share >= 1.0 and e.samples >= WHOLE_SAMPLES and e.duration_s >= least


def _hidden(e: Evidence, i: int, coarse: Mapping[str, float]) -> bool:
    """Whether the sensor moves in other runs, by steps (N, by system) so coarse that backlash alone may hide in one of them."""
    if e.ranges[1 - i].low < NEAR_ZERO * e.ranges[1 - i].high:
        # released to nothing, and still no change
        return False
    if i == 0 and e.ranges[1].span > math.exp(MOST_WRAP) * coarse.get(e.system, math.inf):
        # no friction makes so much of a movement within one step of the input
        return False
    return e.system in coarse


def dead(e: Evidence) -> bool:
    """Whether a sensor is stuck for so long that nothing else can be said of the run."""
    return "failure" in (_stuck(e, 0), _stuck(e, 1))


def silent(e: Evidence) -> bool:
    """Whether the input shows none of its noise for so long while the output moves that it follows nothing, as that of exchanged channels would."""
    return e.sensors[0].silent and _stuck(e, 0) == "failure"


def _stuck(e: Evidence, i: int) -> str:
    s = e.sensors[i]
    if not e.usable or s.still_s < LEAST_S or s.still_share < LEAST_SHARE:
        return ""
    # a sensor that comes back jumps, a run that ends may end in backlash; no output moves on while its input rests, where noise would show in that
    coarse = s.coarse and not s.still_left and not (i == 0 and s.silent)
    if e.stuck_while_n[i] < (WHOLE_MOVED if coarse else LEAST_MOVED) * e.ranges[1 - i].span:
        return ""
    # behind coarse levels no noise tells a dead sensor from an output in backlash, but friction does, if it explains it to one of them
    if i == 1 and s.coarse and min((c.rms_n for c in e.causes.slips if math.isfinite(c.rms_n)), default=math.inf) < s.step_n:
        return ""
    return "failure" if s.still_share > FAILED_SHARE else "remark"

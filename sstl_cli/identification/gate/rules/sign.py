"""A tension with the wrong sign: pulling makes it more negative, or the output falls as the input rises."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "sign", 25
# a zero that is off by this much, or by this part of what the sensor is used for, is a zero offset and not a sign
OFFSET_N, OFFSET_SHARE = 2.5, 0.5


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose tensions push."""
    used: dict[tuple[str, int], float] = {}
    for e in log:
        for i in (0, 1):
            used[e.system, i] = max(used.get((e.system, i), 0.0), e.ranges[i].span)
    negative = {(e.run_id, i): e.usable and _negative(e, i, used[e.system, i]) for e in log for i in (0, 1)}
    for which in ((0, 1), (0,), (1,)):
        hit = [e for e in log if tuple(i for i in (0, 1) if negative[e.run_id, i]) == which]
        if hit:
            lowest = min(e.ranges[i].low for e in hit for i in which)
            channel = " and ".join(WORDS[i] for i in which)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", lowest, "N",
                f"{names([e.run_id for e in hit])}: the {channel} {'are' if len(which) > 1 else 'is'} negative throughout "
                f"(down to {lowest:.4g} N), but a tendon cannot push; the sign is probably flipped",
                "; ".join(f"{CHANNELS[i]} = {{ column = ..., sign = -1 }}" for i in which),
            )  # fmt: skip
    told = {name for (name, _), is_negative in negative.items() if is_negative}
    hit = [e for e in log if e.run_id not in told and e.tendon_like and _mirrored(e)]
    if hit:
        number = min(e.correlation for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", number, "1",
            f"{names([e.run_id for e in hit])}: the output falls as the input rises (correlation {number:.2f}) and follows "
            "it well once its sign is changed; the sign is probably flipped",
            "tension_out_n = { column = ..., sign = -1, offset = (reading at no load) }",
        )  # fmt: skip


def _negative(e: Evidence, i: int, used_n: float) -> bool:
    r = e.ranges[i]
    return CHANNELS[i] in e.tensions and r.middle < 0.0 and -r.low > max(min(OFFSET_N, OFFSET_SHARE * used_n), 3.0 * r.high)


def _mirrored(e: Evidence) -> bool:
    p = e.play
    if p is None or not e.correlation < -0.3 or not e.flipped_rms < 0.06:
        return False
    # the play operator itself can fall: then it fits as recorded, with both slopes negative
    return e.flipped_rms < 0.3 * e.forward_rms or (p.gamma_p < 0.0 and p.gamma_r < 0.0 and p.explained > 0.97)

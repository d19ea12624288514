"""A tension with the wrong sign: pulling makes it more negative, or the output falls as the input rises.

What is negative throughout and still rises with the other channel was zeroed under load (``zero``), not flipped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.common_delay import common_delay
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.folded import beyond_fold, folds
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "sign", 25
# a zero that is off by this much, or by this part of what the sensor is used for, is a zero offset and not a sign
OFFSET_N, OFFSET_SHARE = 2.5, 0.5
# correlation from which on channels rise together, or one falls as the other rises; what lines must explain to tell their order
TOGETHER, SHAPE, LEAST_SHARE = 0.2, 0.97, 0.02
# residual (share of the span) of a record that lines explain
GOOD = 0.06


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose tensions push."""
    negative, zeroed = below(log)
    for which in ((0, 1), (0,), (1,)):
        hit = [e for e in log if tuple(i for i in (0, 1) if (e.run_id, i) in negative) == which and e.run_id not in zeroed]
        if hit:
            lowest = min(e.ranges[i].low for e in hit for i in which)
            channel = " and ".join(WORDS[i] for i in which)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", lowest, "N",
                f"{names([e.run_id for e in hit])}: the {channel} {'are' if len(which) > 1 else 'is'} negative throughout "
                f"(down to {lowest:.4g} N), but a tendon cannot push; the sign is probably flipped",
                "; ".join(f"{CHANNELS[i]} = {{ column = ..., sign = -1 }}" for i in which),
            )  # fmt: skip
    told = {name for name, _ in negative}
    # a movement that repeats, late by half a loop, falls as its input rises
    hit = [e for e in log if e.run_id not in told and e.tendon_like and _mirrored(e)]
    hit = [] if hit and common_delay(log) else hit
    # a sensor that folds at zero in other runs does here, too
    turned = bool(hit) and any(e.tendon_like for e in folds(log))
    hit = [e for e in hit if not (turned and beyond_fold(e))]
    if hit:
        number = min(e.correlation for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", number, "1",
            f"{names([e.run_id for e in hit])}: the output falls as the input rises (correlation {number:.2f}) and follows "
            "it well once its sign is changed; the sign is probably flipped",
            "tension_out_n = { column = ..., sign = -1, offset = (reading at no load) }",
        )  # fmt: skip


def below(log: Sequence[Evidence]) -> tuple[set[tuple[str, int]], set[str]]:
    """Return the channels (run, 0 input or 1 output) that are negative throughout, and the runs of them that were zeroed under load.

    A run that does not tell which of the two it is follows the others with the same channels negative.
    """
    used: dict[tuple[str, int], float] = {}
    for e in log:
        for i in (0, 1):
            used[e.system, i] = max(used.get((e.system, i), 0.0), e.ranges[i].span)
    found = {e.run_id: tuple(i for i in (0, 1) if e.usable and _negative(e, i, used[e.system, i])) for e in log}
    negative = {(name, i) for name, channels in found.items() for i in channels}
    votes = {e.run_id: _zeroed(e, found[e.run_id]) for e in log if found[e.run_id]}
    most = sum(votes.values()) > 0
    return negative, {name for name, vote in votes.items() if vote > 0 or (vote == 0 and most)}


def _zeroed(e: Evidence, channels: tuple[int, ...]) -> int:
    """Return 1 where a negative channel was zeroed under load, -1 where its sign is flipped, 0 where the run does not tell."""
    if len(channels) == 1:
        if min(e.forward_rms, e.flipped_rms) < GOOD and not 0.5 < e.forward_rms / max(e.flipped_rms, 1e-300) < 2.0:
            return 1 if e.forward_rms < e.flipped_rms else -1
        return (e.correlation > TOGETHER) - (e.correlation < -TOGETHER)
    p = e.play
    if p is None or not p.explained > SHAPE or not e.correlation > TOGETHER:
        return 0
    # with both signs flipped the steep line of the release is passed on the way up
    if min(p.gamma_p, p.gamma_r) <= 0.0 or min(p.shares) < LEAST_SHARE:
        return 0
    return (p.gamma_p < p.gamma_r) - (p.gamma_p > p.gamma_r)


def _negative(e: Evidence, i: int, used_n: float) -> bool:
    r = e.ranges[i]
    return CHANNELS[i] in e.tensions and r.middle < 0.0 and -r.low > max(min(OFFSET_N, OFFSET_SHARE * used_n), 3.0 * r.high)


def _mirrored(e: Evidence) -> bool:
    p = e.play
    if p is None or not e.correlation < -0.3 or not e.flipped_rms < 0.06:
        return False
    # the play operator itself can fall: then it fits as recorded, with both slopes negative
    return e.flipped_rms < 0.3 * e.forward_rms or (p.gamma_p < 0.0 and p.gamma_r < 0.0 and p.explained > 0.97)

"""A sensor that shows nothing but its own noise while the other one goes where no friction would let it rest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from sstl_cli.core.sound import whole_of
from sstl_cli.identification.gate.evidence import MOST_WRAP, Evidence
from sstl_cli.identification.gate.lost import NOISE
from sstl_cli.identification.gate.remark import Remark, Severity, names
from sstl_cli.identification.gate.rules.stuck import dead
from sstl_cli.identification.gate.units import CHANNELS, WORDS, column_line

RULE, RANK = "dead", 44
# the zero (share of the other's largest tension) a sensor may be off by
ZERO = 0.05
# what friction, alone or with a slip, leaves (share of the output's span) of a run that it explains, and the part of it that an output may be moved by for that
EXPLAINED, FAR = 0.12, 0.2
# times the noise of sensors from which on noise is none of theirs, and the least (share of the largest tension) that counts as their noise
LOUD, RESOLVED = 10.0, 1e-4
# standard errors by which a correlation of noises that know nothing of each other may be off
CHANCE = 5.0
# bends and systems in which a channel rests at one level that friction would leave at several
SEVERAL = 2
# how much more than the friction that other runs show is beyond doubt
BEYOND = 1.7


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels is noise about a constant though the other pulls far beyond what friction holds."""
    known = [e.wrap / e.passes for e in log if e.slopes.known and e.wrap > 0.0]
    seen = max(known, default=math.inf)
    yield from _both(log)
    yield from _loud(log)
    for i in (0, 1):
        resting = {e.run_id: needed(e, i) for e in log}
        for severity in ("failure", "remark"):
            hit = [e for e in log if resting[e.run_id] > MOST_WRAP and _severity(e, resting[e.run_id], seen) == severity]
            if hit:
                far = max(e.ranges[1 - i].span for e in hit)
                yield Remark(
                    tuple(e.run_id for e in hit), RULE, severity, far, "N",
                    f"{names([e.run_id for e in hit])}: the {WORDS[i]} is noise about a constant "
                    f"({hit[0].ranges[i].middle:.3g} N) while the {WORDS[1 - i]} moves by {far:.3g} N, which no friction holds "
                    "back; the sensor is probably dead or not connected",
                    column_line(i),
                )  # fmt: skip
            yield from _midway([e for e in log if resting[e.run_id] <= MOST_WRAP], i, severity, seen)
        yield from _everywhere([e for e in log if e.usable and e.both_tensions], i, resting)


def _everywhere(log: Sequence[Evidence], i: int, resting: Mapping[str, float]) -> Iterator[Remark]:
    """Yield all runs where a channel rests at one level in all of several bends or systems: friction leaves each line where it was moved to last."""
    if not log or not all(_told_apart(e, i) and _rests(e, i) for e in log) or len({(e.config_id, e.system) for e in log}) < SEVERAL:
        return
    levels, noise_n = [e.ranges[i].middle for e in log], max(e.sensors[i].noise_n for e in log)
    hit = [e for e in log if resting[e.run_id] <= MOST_WRAP]
    if not hit or max(levels) - min(levels) > NOISE * noise_n:
        return
    level, low, high = float(np.median(levels)), min(e.ranges[1 - i].low for e in hit), max(e.ranges[1 - i].high for e in hit)
    holds = max(high / level, level / max(low, noise_n)) if level > 0.0 else math.inf
    yield Remark(
        tuple(e.run_id for e in hit), RULE, "remark", level, "N",
        f"{names([e.run_id for e in hit])}: the {WORDS[i]} stays at {level:.3g} N in every run while the {WORDS[1 - i]} goes from {low:.3g} to {high:.3g} N; "
        f"its sensor is probably dead or not connected (friction of n theta {math.log(holds):.2g} would be needed to let nothing through)",
        column_line(i),
    )  # fmt: skip


def _both(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs both of whose channels are noise that knows nothing of the other one: there is no movement to be seen."""
    # a hold between two pauses of the recorder is a part of a run that moved
    moved = {whole_of(e.run_id) for e in log if e.usable and not _still(e)}
    hit = [e for e in log if _still(e) and whole_of(e.run_id) not in moved]
    if hit:
        levels = [float(np.median([e.ranges[i].middle for e in hit])) for i in (0, 1)]
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", float(len(hit)), "1",
            f"{names([e.run_id for e in hit])}: input and output are noise about a constant ({levels[0]:.3g} and {levels[1]:.3g} N), each of its own; "
            "nothing was moved, or neither sensor is connected",
            "leave these runs out, or take the columns of the two sensors",
        )  # fmt: skip


def _loud(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output is noise such as no sensor here has: readings in random order, or of nothing; what such an input does is unrelated."""
    shown = [e for e in log if e.usable and e.both_tensions]
    hit = []
    for e in (e for e in shown if e.but_noise(1) and not e.but_noise(0) and e.sensors[1].fine and e.hums[1] is None):
        own = [o.sensors[1].noise_n for o in shown if o.system == e.system and not o.but_noise(1)]
        # of a log without a run that moves the input tells what sensors are like
        usual = max(float(np.median(own)) if own else e.sensors[0].noise_n, RESOLVED * e.ranges[0].high)
        if e.sensors[1].noise_n > max(LOUD * usual, ZERO * e.ranges[0].high):
            hit.append((e, usual))
    if hit:
        e, usual = max(hit, key=lambda h: h[0].sensors[1].noise_n)
        yield Remark(
            tuple(e.run_id for e, _ in hit), RULE, "failure", e.sensors[1].noise_n, "N",
            f"{names([e.run_id for e, _ in hit])}: the output is noise of {e.sensors[1].noise_n:.3g} N, {e.sensors[1].noise_n / usual:.3g} times that of "
            "the sensors here, while the input moves; its readings were probably put in another order, or its sensor is not connected",
            column_line(1),
        )  # fmt: skip


def _still(e: Evidence) -> bool:
    # a correlation of noises is one over the root of their number; rows in another order belong together
    return e.usable and e.both_tensions and e.but_noise(0) and e.but_noise(1) and abs(e.raw_correlation) * math.sqrt(e.samples) < CHANCE


def _midway(log: Sequence[Evidence], i: int, severity: Severity, seen: float) -> Iterator[Remark]:
    """Yield runs one of whose channels is such noise for a part of the run."""
    hit = [
        (e, found)
        for e in log
        if (found := e.lost[i]) is not None and (w := lost_by(e, i)) > MOST_WRAP and _severity(e, w, seen) == severity
    ]
    if hit:
        _, found = max(hit, key=lambda h: h[1].length_s)
        yield Remark(
            tuple(e.run_id for e, _ in hit), RULE, severity, found.length_s, "s",
            f"{names([e.run_id for e, _ in hit])}: the {WORDS[i]} is noise about a constant ({found.level_n:.3g} N) for {found.length_s:.3g} s from "
            f"{found.at_s:.4g} s on while the {WORDS[1 - i]} goes up to {found.reached_n:.3g} N, which no friction holds back; the sensor has probably "
            "died or lost its connection there",
            f"skip this stretch, or {CHANNELS[i]} = {{ column = (another sensor) }}",
        )  # fmt: skip


def needed(e: Evidence, i: int) -> float:
    """Return n theta that friction would need to keep a channel where it rests, 0 where it moves by more than its noise."""
    high = e.ranges[1 - i].high
    if not _told_apart(e, i) or not _rests(e, i):
        return 0.0
    return math.log(high / (abs(e.ranges[i].middle) + ZERO * high))


def _rests(e: Evidence, i: int) -> bool:
    """Whether a channel moves by no more than its noise."""
    return e.ranges[i].span <= NOISE * e.sensors[i].noise_n


def lost_by(e: Evidence, i: int) -> float:
    """Return n theta that friction would need to keep a channel where it rests for a part of the run, 0 where it never does."""
    found, high = e.lost[i], e.ranges[1 - i].high
    if found is None or not _told_apart(e, i) or found.reached_n <= 0.0:
        return 0.0
    if _explained(e):
        return 0.0
    return math.log(found.reached_n / (abs(found.level_n) + ZERO * high))


def _explained(e: Evidence) -> bool:
    """Whether friction, alone or with a slip of the whole run (as a late output), explains the run, its rests with it."""
    c = e.causes
    # of what is moved far, too little is compared
    known = [v for v in (*c.slips, c.reversed) if v is not c.moved or abs(v.size) < FAR * e.duration_s]
    return min((v.rms_n for v in known if math.isfinite(v.rms_n)), default=math.inf) < EXPLAINED * e.ranges[1].span


def _told_apart(e: Evidence, i: int) -> bool:
    """Whether the noise of a channel shows, and the other one moves by much of its tension."""
    s, moves = e.sensors[i], e.ranges[1 - i]
    if not e.usable or CHANNELS[i] not in e.tensions or not e.both_tensions or dead(e):
        return False
    # between coarse levels a movement may hide
    if not (s.fine and s.noise_n > 0.0) or moves.high <= 0.0:
        return False
    return moves.low >= -0.25 * moves.high and moves.span >= 0.5 * moves.high


def _severity(e: Evidence, wrap: float, seen: float) -> Severity:
    """A failure where the other runs show that friction is by far smaller."""
    return "failure" if wrap > BEYOND * seen * e.passes else "remark"

"""An output that comes before its input, or so late that its clock must be another."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from statistics import median

from sstl_cli.identification.gate.common_delay import common_delay
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.leading import HALF, by_speed, leading
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.drift import drift_of
from sstl_cli.identification.gate.rules.limit import limited
from sstl_cli.identification.gate.rules.noiseless import smooth
from sstl_cli.identification.gate.rules.stuck import dead
from sstl_cli.identification.gate.units import column_line

RULE, RANK = "lead", 35
# part of the output's span that may remain once it is moved in time, and of what any other slip leaves; where that is so little that no other run is asked
LITTLE, LESS, CLEAR = 0.08, 0.5, 0.2
# the slowest channel of the catalogue is that late
LATE_S = 0.2
# what lines and delay must explain of an output that is only late
SHAPE = 0.97
# part of the input's span over which pull and release must be seen for a run to be known as in time
SEEN = 0.1
# part of a delay by which it must grow along the run
GROWS = 0.2
# share of what friction alone leaves that may remain once the output is moved and the lines are those of friction
HELD = 0.3
# noises that a delay of half a loop and more must leave
LITTLE_LEFT = 2.0
# part of a delay by which those of one clock differ
AGREES = 0.2
# delay of two passes over that of one where the line's own drag makes it, and the factor within which that is so; beyond both of a system's usual delay it is none
PASSES, DRAG = 2.0, 1.5
# a filter of that many samples is no clock
FILTER = 10.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output must be moved in time to follow its input."""
    drifts = [d for e in log if (d := drift_of(e)) != 0.0 and e.loops > 1]
    drift = sorted(drifts, key=abs)[len(drifts) // 2] if drifts else 0.0
    # an output that is cut off ends its rise early and no clock is to blame
    cut = {e.run_id for e in limited(log, 1)}
    common = common_delay(log)
    if common:
        yield _clocks([e for e in log if e.tendon_like], common)
        return
    for early in (True, False):
        # a run too short to show the drift of the others shows its mean as a delay
        apart = leading(log) if early else []
        hit = [
            e
            for e in log
            if (_moved(e, early) or (early and _ahead(e, log)) or e in apart) and e.run_id not in cut and not _drifted(e, drift)
        ]
        if early and hit:
            # of one clock all runs lead by as much, those with them that alone would not tell
            usual = median([_size(e) for e in hit])
            hit = [e for e in log if e in hit or (e.ahead is not None and abs(e.ahead.delay_s - usual) < AGREES * abs(usual))]
        if not early:
            # creep and slow friction delay some movements and change their shape, a clock moves all of them as they are
            # and a filter smooths: what is without noise is late by it, and no clock's; what an output that goes one way lacks is backlash as well
            hit = [e for e in hit if e.propagates_back and e.loops and e.play is not None and e.play.explained > SHAPE and not smooth(e, 1)]
            hit = _beyond_drag(hit, log)
            hit = [e for e in hit if _clear(e) or not any(_in_time(o) for o in log if o.system == e.system)]
            if hit:
                usual = median([_size(e) for e in hit])
                hit = [e for e in log if e in hit or _agrees(e, usual)]
        if early:
            # a command is ahead of what follows it, and no clock mends that
            commands = [e for e in hit if smooth(e, 1)]
            # a straight part of one shows no rounding, but no noise either
            commands += [e for e in hit if commands and e not in commands and e.sensors[1].noise_n < commands[0].sensors[1].noise_n]
            yield from _commanded(commands)
            hit = [e for e in hit if e not in commands]
        if not hit:
            continue
        delays = sorted((_size(e) for e in hit), key=abs)
        delay = delays[len(delays) // 2]
        yield _clocks(hit, delay)


def _clocks(hit: Sequence[Evidence], delay: float) -> Remark:
    """Return what is said of runs whose output is moved in time by ``delay`` (s)."""
    early = delay < 0.0
    way = "comes before its input, which no tendon does" if early else "comes too late for friction"
    # what goes through a filter comes late, too; without it a mean over samples behind the moment is the same to friction
    filtered = "" if early else ", or the output alone went through a filter (a mean of the samples before, a low-pass)"
    unfiltered = "" if early else ", or tension_out_n = { column = (the output before the filter) }"
    return Remark(
        tuple(e.run_id for e in hit), RULE, "failure" if early else "remark", delay, "s",
        f"{names([e.run_id for e in hit])}: the output {way} (by {abs(delay):.3g} s); the two channels probably have "
        f"clocks of their own that do not start together{filtered}",
        f'[clocks] align = "apply" (with a column that both sides recorded as content){unfiltered}',
    )  # fmt: skip


def _commanded(hit: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output comes before its input and has none of its noise."""
    if hit:
        delay = median([_size(e) for e in hit])
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", delay, "s",
            f"{names([e.run_id for e in hit])}: the output comes before its input (by {abs(delay):.3g} s), which no tendon does, and is without the noise of "
            "the input; it is probably the command (or a smoothed copy of the input) and not the sensor",
            column_line(1),
        )  # fmt: skip


def _in_time(e: Evidence) -> bool:
    """Whether the output of this run is known to come soon after its input."""
    p = e.play
    if not e.tendon_like or p is None or min(p.reaches) < SEEN:
        # a movement to and fro within backlash looks the same with a delay and with more friction
        return False
    return p.explained > 0.98 and p.delay_se < 0.1 * LATE_S and abs(p.delay_s) < 0.5 * LATE_S


def _drifted(e: Evidence, drift: float) -> bool:
    """Whether the drift that other runs show moves this one by what it is moved."""
    return drift != 0.0 and e.play is not None and 0.0 < e.play.delay_s / (drift * e.duration_s) < 1.5


def _clear(e: Evidence) -> bool:
    """Whether a delay explains a run so much better than all else that it needs no other run to be believed."""
    c = e.causes
    rest = (c.gain, c.zero_in, c.zero_out, c.slow, c.creep, c.speed, c.reversed)
    return c.left(c.moved.rms_n) < CLEAR * min(c.left(v.rms_n) for v in rest)


def _beyond_drag(hit: Sequence[Evidence], log: Sequence[Evidence]) -> list[Evidence]:
    """Return the late runs that drag of the line does not delay: it delays every pass, so that the loop is late by about twice what actuation is, a clock all runs alike."""
    late = {s: [e.causes.moved.size for e in log if e.system == s and e.tendon_like and _delayed(e)] for s in ("act", "sstl")}
    if not hit or not late["act"] or not late["sstl"]:
        return list(hit)
    usual = {s: median(sizes) for s, sizes in late.items()}
    if not PASSES / DRAG < usual["sstl"] / usual["act"] < PASSES * DRAG:
        return list(hit)
    return [e for e in hit if _size(e) > PASSES * DRAG * usual[e.system]]


def _delayed(e: Evidence) -> bool:
    """Whether an output is late by what friction leaves far less with than without."""
    return e.causes.holds(e.causes.moved.rms_n) and e.causes.moved.size > 0.0


def _agrees(e: Evidence, usual: float) -> bool:
    """Whether the delay that other runs tell explains this one, too."""
    c = e.causes
    return (
        e.tendon_like
        and c.holds(c.moved.rms_n)
        and c.left(c.moved.rms_n) < c.left(c.slow.rms_n)
        and abs(c.moved.size - usual) < AGREES * usual
    )


def _size(e: Evidence) -> float:
    """Return by how much an output is moved (s)."""
    known = math.isfinite(e.causes.moved.size)
    return e.ahead.delay_s if e.ahead is not None and (e.ahead.sure or not known) else e.causes.moved.size


def _ahead(e: Evidence, log: Sequence[Evidence]) -> bool:
    """Whether an output comes before its input by what its samples alone tell, and no other run shows another lead: then it is no clock's."""
    p = e.play
    if e.ahead is None or not e.ahead.sure or p is None or not e.tendon_like or not e.wide or dead(e):
        return False
    leads = [o.ahead.delay_s for o in log if o.ahead is not None and o.ahead.shown]
    agree = [d for d in leads if abs(d - e.ahead.delay_s) < AGREES * abs(e.ahead.delay_s)]
    return p.gamma_p > 0.0 and p.explained > SHAPE and abs(e.ahead.delay_s) < HALF * e.loop_s and 2 * len(agree) > len(leads)


def _moved(e: Evidence, early: bool) -> bool:
    p = e.play
    if not e.tendon_like or not e.wide or p is None or not p.explained > 0.9 or not 0.0 < p.gamma_p < p.gamma_r or dead(e):
        return False
    if e.correlation < 0.2 and not p.explained > SHAPE:
        return False
    c = e.causes
    if c.moved.rms_n > LITTLE * e.ranges[1].span:
        return False
    # of a movement that repeats, no delay of half a loop and more is known; nor is one where friction never slides both ways
    if abs(c.moved.size) > HALF * e.loop_s and c.moved.rms_n > LITTLE_LEFT * c.noise_n:
        return False
    if math.log(e.ranges[0].high / max(e.ranges[0].low, 1e-9 * e.ranges[0].high)) < 2.0 * e.causes.moved.wrap:
        return False
    # the lines of friction must follow it, not without the delay, and with nothing else
    rest = min(c.left(v.rms_n) for v in (c.gain, c.zero_in, c.zero_out, c.creep, c.reversed))
    if not c.holds(c.moved.rms_n, HELD) or c.left(c.moved.rms_n) > LESS * rest:
        return False
    # a low-pass is late as well, but by more in fast parts than in slow ones
    if c.left(c.slow.rms_n) < c.left(c.moved.rms_n):
        return False
    # where that is not known it may be friction's
    if math.isnan(c.speed.rms_n) or by_speed(e):
        return False
    # a delay that grows is a drift
    grows = abs(p.drift) * e.duration_s > GROWS * abs(p.delay_s)
    if grows and p.drifting_rms_n < 0.8 * p.delayed_rms_n and abs(p.drift) > 8.0 * p.drift_se:
        return False
    least = max(6.0 * p.delay_se, 2.5 * max(e.dt_s, e.sensors[0].refresh_s, e.sensors[1].refresh_s))
    size = c.moved.size
    return size < -least if early else size > max(least, LATE_S, FILTER * e.dt_s)

"""Runs that lead beside runs that do not, or all by one time: sensors and clock are those of the log, so that its runs tell what friction of any law makes of a delay."""

from __future__ import annotations

from collections.abc import Sequence

from sstl_cli.identification.gate.ahead import ERRORS, PERIODS
from sstl_cli.identification.gate.evidence import Evidence

# what lines and a delay must explain for the delay to be compared, and its standard errors (s)
SHAPE, KNOWN_S = 0.98, 0.01
# runs in time beside which one leads, and the part of the spread of their delays and of its own lead by which it must be apart from them
BESIDE, SPREAD, PART = 2, 1.0, 0.5
# part of a loop that a delay reaches: of a movement that repeats no longer one is known
HALF = 0.4
# what a delay may leave of what any other explanation leaves, how alike (part of it) the leads of one clock are, and runs that must tell it
LESS, ALIKE, AGREE = 0.5, 0.15, 3
# how many times as much friction by speed must leave
BY_SPEED = 3.0


def leading(log: Sequence[Evidence]) -> list[Evidence]:
    """Return the few runs that lead while the others come after their input, or all where they lead by one time in bends that rub differently."""
    known = [(e.play.delay_s, e) for e in log if e.play is not None and _timed(e)]
    early = [(d, e) for d, e in known if e.ahead is not None and e.ahead.shown and e.ahead.tells and d < -_least(e)]
    others = [(d, e) for d, e in known if all(e is not o for _, o in early)]
    rest = [d for d, _ in others]
    # where friction turns the outputs of others early, and beyond half a loop, a clock's is the lead that leaves nothing but noise
    turns = 2 * sum(_leads(d, e) for d, e in others) > len(rest)
    early = [(d, e) for d, e in early if (e.ahead is not None and e.ahead.sure) or not (turns or abs(d) > HALF * e.loop_s or by_speed(e))]
    if len(rest) >= max(BESIDE, 2 * len(early)) and early:
        first = min(rest)
        return [e for d, e in early if first - d > max(SPREAD * (max(rest) - first), PART * abs(d), _least(e))]
    return [] if rest else _together(early)


def by_speed(e: Evidence) -> bool:
    """Whether friction that falls with speed, which turns the output before the input turns, leaves nearly as little as a delay."""
    c = e.causes
    return c.speed.rms_n <= BY_SPEED * max(c.moved.rms_n, c.noise_n)


def _together(early: Sequence[tuple[float, Evidence]]) -> list[Evidence]:
    """Return runs all of which lead by one time, in several bends, where no other explanation comes near in half of them."""
    delays = sorted(d for d, _ in early)
    if len(delays) < AGREE or len({(e.config_id, e.system) for _, e in early}) < AGREE or delays[-1] > (1.0 - ALIKE) * delays[0]:
        return []
    clear = [e for _, e in early if _clear(e)]
    return [e for _, e in early] if 2 * len(clear) >= len(early) else []


def _timed(e: Evidence) -> bool:
    """Whether lines and a delay explain a run well enough for its delay to be compared with that of others."""
    p = e.play
    return e.tendon_like and e.wide and p is not None and p.explained > SHAPE and p.delay_se < KNOWN_S and 0.0 < p.gamma_p < p.gamma_r


def _leads(delay_s: float, e: Evidence) -> bool:
    """Whether an output surely comes before its input, by however little."""
    return e.play is not None and -delay_s > max(ERRORS * e.play.delay_se, e.dt_s)


def _least(e: Evidence) -> float:
    return PERIODS * max(e.dt_s, e.sensors[0].refresh_s, e.sensors[1].refresh_s)


def _clear(e: Evidence) -> bool:
    """Whether a delay leaves much less than friction with any other slip, and by any other law."""
    c = e.causes
    rest = min(c.left(v.rms_n) for v in (*c.slips, c.reversed) if v is not c.moved)
    return c.left(c.moved.rms_n) < LESS * rest

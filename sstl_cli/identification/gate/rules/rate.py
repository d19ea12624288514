"""A sampling rate that differs between the runs of a log."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.movement import unlike
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "rate", 18
# factor between two rates; between those of clocks whose means tell it as well, as a clock that jitters or counts whole milliseconds has a
# median of its own
APART, NEAR = 1.25, 1.1
LIKELY_S = 0.005
# of the logarithm: loops of one movement, counted
SAME_SPEED = 0.15
# what the movement of one run leaves of that of another where they are the same by samples, and of what it leaves by the clocks
ALIKE, LESS = 0.1, 0.3
# standard errors from which on a lag is known, and the part of the difference in rate in it from which on, and below which, the clock is (not) off
SURE, CLOCK, NO_CLOCK = 5.0, 0.7, 0.3
Clock = Literal["", "other", "either"]
# factors between units of time
UNITS = {1e3: "ms", 1e6: "us", 60.0: "min"}


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the runs that are sampled otherwise than most."""
    # rows out of order have no rate
    runs = [e for e in log if e.samples > 16 and e.dt_s > 0.0 and e.usable]
    if len(runs) < 2:
        return
    steps = np.array([e.dt_s for e in runs])
    # the period that most runs share
    near = [int(np.sum(np.abs(np.log(steps / s)) < np.log(NEAR))) for s in steps]
    # of two rates as frequent it is that of a logger, some hundred samples a second
    usual = float(steps[np.lexsort((np.abs(np.log(steps / LIKELY_S)), -np.array(near)))[0]])
    ratios = _ratios(runs, usual)
    groups: dict[tuple[str | None, float], list[Evidence]] = {}
    for e in runs:
        if (ratio := ratios[e.run_id]) != 1.0:
            groups.setdefault((_unit(ratio), round(math.log(ratio), 1)), []).append(e)
    # a logger of its own for each system is no slip
    rates = {(e.system, ratios[e.run_id] > 1.0, ratios[e.run_id] < 1.0) for e in runs}
    own = len(rates) == len({e.system for e in runs})
    others = [e for e in runs if ratios[e.run_id] == 1.0]
    for (unit, _), hit in groups.items():
        clocks = {e.run_id: _clock(e, others, usual) if unit is None else "" for e in hit}
        for clock in ("other", "either"):
            yield from _told([e for e in hit if clocks[e.run_id] == clock], usual, None, clock)
        if unit is not None or not own:
            yield from _told([e for e in hit if not clocks[e.run_id]], usual, unit)


def _ratios(runs: Sequence[Evidence], usual: float) -> dict[str, float]:
    """Return the sampling period of each run over the usual one, 1 where they are the same."""
    means = {e.run_id: e.duration_s / (e.samples - 1) for e in runs}
    mean = float(np.median([means[e.run_id] for e in runs if _size(e.dt_s / usual) < NEAR]))

    def known(e: Evidence) -> bool:
        ratio = e.dt_s / usual
        return _size(ratio) > APART or min(_size(ratio), (means[e.run_id] / mean) ** math.copysign(1.0, math.log(ratio))) > NEAR

    return {e.run_id: e.dt_s / usual if known(e) else 1.0 for e in runs}


def _size(ratio: float) -> float:
    return max(ratio, 1.0 / ratio)


def _told(hit: list[Evidence], usual: float, unit: str | None, clock: Clock = "") -> Iterator[Remark]:
    if not hit:
        return
    ids = tuple(e.run_id for e in hit)
    step = hit[0].dt_s
    why = (
        f"time is probably in {unit} in one of them"
        if unit
        else "they were probably recorded or exported differently, which is no fault by itself"
    )
    mend = f'time_s = {{ column = ..., unit = "{unit}" }} (for this file)' if unit else "none needed if the logger was set so"
    if clock:
        why = f"and the same movement goes {usual / step:.3g} times as fast in them, so that their clock is probably off by this factor"
        mend = f"time_s = {{ rate_hz = {1.0 / usual:.6g} }} (for this file)"
    if clock == "either":
        why += ", unless the movement was played sample by sample at this rate"
    yield Remark(
        ids, RULE, "failure" if unit else "remark", 1.0 / step, "Hz",
        f"{names(ids)}: sampled at {1.0 / step:.4g} Hz, the other runs at {1.0 / usual:.4g} Hz; {why}",
        mend,
    )  # fmt: skip


def _clock(e: Evidence, others: Sequence[Evidence], usual: float) -> Clock:
    """Return whether the clock of a run is another one, or may be: it goes the way of others of its movement, sample by sample."""
    # other movements may bear one name, and their loops last about as long by chance
    same = [o for o in others if o.trajectory == e.trajectory and _same(e, o)]
    if not same:
        return ""
    named = e.trajectory is not None and _speeded(e, same, usual)
    # a drive has a lag of its own: it is as many samples as before where the clock is off, and as long where the movement is
    lags = [w for o in same if (w := _lag(e, o)) is not None]
    off = float(np.median(lags)) if lags else math.nan
    return "" if off < NO_CLOCK else "other" if named or off > CLOCK else "either"


def _same(e: Evidence, o: Evidence) -> bool:
    """Whether two runs move alike by their samples, and not at all by their clocks."""
    by_sample = unlike(e.movement, o.movement)
    return by_sample < ALIKE and by_sample < LESS * unlike(e.movement, o.movement, e.dt_s / o.dt_s)


def _lag(e: Evidence, o: Evidence) -> float | None:
    """Return the part of the difference in rate that the lags behind the reference show: 1 where the clock is off, 0 where it is not."""
    (mine, error), (theirs, other) = e.reference_lag, o.reference_lag
    if not (mine > SURE * error and theirs > SURE * other):
        return None
    return math.log(mine / theirs) / math.log(e.dt_s / o.dt_s)


def _speeded(e: Evidence, beside: Sequence[Evidence], usual: float) -> bool:
    """Whether the movement is faster, or slower, than in the other runs of its trajectory by what the sampling period is."""
    alike = [o.loop_s for o in beside if o.loops > 1]
    # movements of one name may differ in speed by themselves
    one = bool(alike) and max(alike) < min(alike) * math.exp(SAME_SPEED)
    return one and e.loops > 1 and abs(math.log(e.loop_s / float(np.median(alike)) * usual / e.dt_s)) < SAME_SPEED


def _unit(ratio: float) -> str | None:
    return next((name for size, name in UNITS.items() if abs(math.log(_size(ratio) / size)) < 0.05), None)

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
# most rows of which one may be left, how near a whole part of them loops must be, and runs of its movement beside it
MOST_PART, WHOLE_PART, BESIDE = 10, 0.2, 2
# samples from which on a channel is held
HELD = 1.5
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
    yield from _thinned(others)
    for (unit, _), hit in groups.items():
        clocks = {e.run_id: _clock(e, others, usual) if unit is None else "" for e in hit}
        for clock in ("other", "either"):
            yield from _told([e for e in hit if clocks[e.run_id] == clock], usual, None, clock)
        if unit is not None or not own:
            yield from _told([e for e in hit if not clocks[e.run_id]], usual, unit)


def _thinned(runs: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the run that has the stamps of all others and lasts a whole part of what they do, in the same movement by its rows.

    A movement that is played faster is played so on purpose: in more than one run, beside one of the usual speed on the same bend, or under a name of its own.
    What keeps time without the logger tells one from the other; where nothing does it is asked, if all other runs of this name go round at one speed:
    of a pull alone it is not, as any other one is like it.
    """
    found = []
    # a movement may be repeated another number of times in each run
    for e in runs:
        slower = [(o, k) for o in runs if o is not e and o.trajectory == e.trajectory and (k := _part(e, o)) > 1]
        # one other run may have gone the same way among all that go round as slowly
        alike = [(o, k) for o, k in slower if _same_rows(e, o, k)]
        if alike and len(slower) >= BESIDE:
            found.append((e, alike))
    if len(found) != 1:
        return
    e, alike = found[0]
    k = alike[0][1]
    others = [o for o, _ in alike]
    bend = [o for o in runs if o is not e and (o.config_id, o.location) == (e.config_id, e.location)]
    lags, renewals = _lags(e, bend, k), _renewals(e, others, k)
    # a line that gives way has another lag in the loop than in its first half
    sure = any(v > CLOCK for v in renewals) or min(_lags(e, [o for o in bend if o.system == e.system], k), default=0.0) > CLOCK
    sound = any(v < NO_CLOCK for v in renewals) or (bool(lags) and float(np.median(lags)) < NO_CLOCK)
    played = any((o.config_id, o.location, o.system) == (e.config_id, e.location, e.system) for o in others)
    if sound or not (
        sure or (e.comes_back and not played and _one_speed([o for o in runs if o is not e and o.trajectory == e.trajectory]))
    ):
        return
    rows = {2: "every second row", 3: "every third row"}.get(k, f"one row of {k}")
    why = (
        f"it probably holds {rows} of its recording under the rate of all, as its lag behind the reference, or the period at which a channel is renewed, is 1/{k} of theirs, too"
        if sure
        else f"does it hold {rows} of its recording under the rate of all, or was this movement alone played {k} times as fast?"
    )
    yield Remark(
        (e.run_id,), RULE, "remark", 1.0 / e.dt_s, "Hz",
        f"{names([e.run_id])}: stamped every {e.dt_s:.3g} s as the other runs are, but it goes through the movement of {names([o.run_id for o in others])} in 1/{k} of their time; {why}",
        f"time_s = {{ rate_hz = {1.0 / (k * e.dt_s):.6g} }} (for this file{'' if sure else ', if rows were left out'})",
    )  # fmt: skip


def _lags(e: Evidence, bend: Sequence[Evidence], k: int) -> list[float]:
    """Return the parts of a factor between two clocks in the lag behind the reference: that of a drive is its own on every bend, and about as long whatever is played there."""
    return [w for o in bend if (w := _lag_by(e, o, float(k))) is not None]


def _renewals(e: Evidence, others: Sequence[Evidence], k: int) -> list[float]:
    """Return the part of a factor between two clocks in the periods at which channels are renewed, of those that the others hold: a sensor keeps its own time."""
    told = []
    for i in (0, 1):
        theirs = float(np.median([o.sensors[i].refresh_s for o in others]))
        # no channel is renewed more often than it is logged
        most = min(float(k), theirs / e.dt_s)
        if most > HELD and e.sensors[i].refresh_s > 0.0:
            told.append(math.log(theirs / e.sensors[i].refresh_s) / math.log(most))
    return told


def _part(e: Evidence, o: Evidence) -> int:
    """Return the whole part of the rows of another run's loop that a run has, 1 where it is none or the stamps of both differ."""
    k = round(o.loop_s / e.loop_s) if e.loop_s > 0.0 else 1
    # loops are counted, and the last one may be none
    close = 1 < k <= MOST_PART and abs(o.loop_s / (k * e.loop_s) - 1.0) < WHOLE_PART
    return k if close and _size(e.dt_s / o.dt_s) < NEAR else 1


def _one_speed(runs: Sequence[Evidence]) -> bool:
    """Whether runs of one movement are all played at one speed."""
    loops = [e.loop_s for e in runs]
    return max(loops) < min(loops) * math.exp(SAME_SPEED)


def _same_rows(e: Evidence, o: Evidence, k: int) -> bool:
    """Whether two runs move alike where one has one of ``k`` rows of the other, and not at all by their stamps."""
    by_row = unlike(e.movement, o.movement, float(k))
    return by_row < ALIKE and by_row < LESS * unlike(e.movement, o.movement)


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
    # one pull is like any other, however fast
    told: Clock = "other" if named or off > CLOCK else "either" if e.comes_back else ""
    return "" if off < NO_CLOCK else told


def _same(e: Evidence, o: Evidence) -> bool:
    """Whether two runs move alike by their samples, and not at all by their clocks."""
    by_sample = unlike(e.movement, o.movement)
    return by_sample < ALIKE and by_sample < LESS * unlike(e.movement, o.movement, e.dt_s / o.dt_s)


def _lag(e: Evidence, o: Evidence) -> float | None:
    """Return the part of the difference in rate that the lags behind the reference show: 1 where the clock is off, 0 where it is not."""
    return _lag_by(e, o, o.dt_s / e.dt_s)


def _lag_by(e: Evidence, o: Evidence, factor: float) -> float | None:
    """Return the part of a factor between two clocks by which the lag of one is shorter than that of the other, None where they do not show."""
    (mine, error), (theirs, other) = e.reference_lag, o.reference_lag
    if not (mine > SURE * error and theirs > SURE * other):
        return None
    return math.log(theirs / mine) / math.log(factor)


def _speeded(e: Evidence, beside: Sequence[Evidence], usual: float) -> bool:
    """Whether the movement is faster, or slower, than in the other runs of its trajectory by what the sampling period is."""
    alike = [o.loop_s for o in beside if o.loops > 1]
    # movements of one name may differ in speed by themselves
    one = bool(alike) and max(alike) < min(alike) * math.exp(SAME_SPEED)
    return one and e.loops > 1 and abs(math.log(e.loop_s / float(np.median(alike)) * usual / e.dt_s)) < SAME_SPEED


def _unit(ratio: float) -> str | None:
    return next((name for size, name in UNITS.items() if abs(math.log(_size(ratio) / size)) < 0.05), None)

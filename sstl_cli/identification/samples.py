"""What is wrong with the samples of one run, all of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.sound import FASTEST_S, GAP_PERIODS, LARGEST, OPTIONAL, SLOPES, SMALLEST, TENSIONS, too_fast, too_small, unsound, within
from sstl_cli.identification import brief, filtering, repeats
from sstl_cli.identification.gate.dropouts import MEND, dropouts_of
from sstl_cli.identification.gate.live import STUCK_SAMPLES, Live, lasting, live_of, noisy
from sstl_cli.identification.gate.rules.magnitude import impossible
from sstl_cli.identification.gate.sensors import digits_lost, quantisation
from sstl_cli.identification.gate.sequence import in_turn
from sstl_cli.identification.gate.stamps import gaps_of, mend_backward, mend_repeated

Array = NDArray[np.float64]
Level = Literal["failure", "remark"]
FAILURE: Final = "failure"
REMARK: Final = "remark"
MIN_SAMPLES = 16
LEAD = "lead_mm"
# spreads of the second differences off both neighbours
SPIKE_SPREADS = 6.0
# share of both by which two gaps of levels may differ and be one
EVEN = 0.02
# steps of a converter by which rounding alone makes a sample leave both neighbours
ROUNDED = 1.5
# part of the samples that makes spikes a fault, levels that make a converter coarse, and the fewest spikes that are compared
MANY, LEVELS, LEAST_SPIKES = 0.02, 16, 8
# part of its readings that a channel repeats from which on repeats say nothing
STILL = 0.05
# second differences, as part of the span, that rounding to single precision makes of a record without noise
ROUNDING = 1e-6
# jitter of the stamps (share of the period) below which a long step is a missing row by itself; stamps on either side that tell else
STEADY, BESIDE, FAR = 0.05, 8, 64


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong (failure) or worth knowing (remark)."""

    level: Level
    what: str
    column: str
    count: int
    detail: str
    fix: str


@dataclass(frozen=True)
class Piece:
    """Samples of one run as they stand in the file: nulls are NaN, and counted."""

    run_id: str | None
    columns: dict[str, Array]
    labels: dict[str, list[object]] = field(default_factory=dict)
    nulls: dict[str, int] = field(default_factory=dict)


def findings(piece: Piece, optional: tuple[str, ...] = ()) -> list[Finding]:
    """Return every finding on one run of a log; ``optional`` columns may be null.

    Time is in s and tensions are in N; each array has the shape (n,).
    """
    found = _labels(piece)
    n = len(next(iter(piece.columns.values()), ()))
    if n < MIN_SAMPLES:
        found.append(Finding(FAILURE, "too few samples", "", n, f"{n} samples", "record longer or drop the run"))
        if brief.plain(piece.columns, piece.nulls):
            return found
    for name, values in piece.columns.items():
        if name == LEAD:
            found += _lead(values)
            continue
        found += _values(name, values, piece.nulls.get(name, 0), name in optional)
    if "time_s" in piece.columns:
        found += _time(piece.columns)
    usable = {c: piece.columns[c] for c in TENSIONS if c in piece.columns}
    usable = {c: v for c, v in usable.items() if n >= MIN_SAMPLES and not bool(unsound(v).any())}
    reach = max((float(np.ptp(v)) for v in usable.values()), default=0.0)
    period = filtering.sampling(piece.columns["time_s"]) if n > 1 and "time_s" in piece.columns else math.nan
    grains = {name: _grain(values) for name, values in usable.items()}
    lives = {name: live_of(values, grains[name][1] or quantisation(values)) for name, values in usable.items()}
    for name, values in usable.items():
        other = next((v for o, v in usable.items() if o != name), None)
        found += _signal(name, values, reach, other, grains[name], lives[name], period)
    if any(f.what == "digits lost" for f in found):
        # a channel that turns within one decade shows it less
        found = [f for f in found if f.what not in ("spikes", "saturation")]
    if len(usable) == 2:
        first, second = usable.values()
        both = (lives[TENSIONS[0]], lives[TENSIONS[1]])
        found = _ordered(found, first, second, both)
        found += _frozen(first, second, both)
    return found


def table_findings(columns: dict[str, Array], nulls: dict[str, int], required: list[str]) -> list[Finding]:
    """Return findings on the numbers of any other table (Theta, commands, scores)."""
    found = []
    for name, values in columns.items():
        found += _values(name, values, nulls.get(name, 0), name not in required)
        if name.endswith("_se"):
            bad = int(np.count_nonzero(values < 0))
            if bad:
                found.append(Finding(FAILURE, "negative standard error", name, bad, f"{bad} rows", "identify Theta again"))
        if name in SLOPES and (bad := int(np.count_nonzero(values < SMALLEST))):
            detail = f"{float(np.nanmin(values)):.3g} in one of {bad} rows: a loop rises"
            found.append(Finding(FAILURE, "no slope", name, bad, detail, "identify Theta again"))
    return found


def _labels(piece: Piece) -> list[Finding]:
    found = []
    if piece.run_id is None:
        found.append(Finding(FAILURE, "run_id is null", "run_id", 1, "samples without a run", "give every sample a run_id"))
    for name, values in piece.labels.items():
        if len(values) > 1:
            shown = ", ".join(map(repr, values[:4]))
            fix = "split the run"
            if in_turn([piece.columns[c] for c in TENSIONS if c in piece.columns]):
                shown += "; the samples go to and fro between two movements: two recordings are interleaved"
                fix = "give the rows of each recording a run_id of their own"
            found.append(Finding(FAILURE, "label changes within the run", name, len(values), shown, fix))
    wrong = [v for v in piece.labels.get("system", []) if v not in ("act", "sstl")]
    if wrong:
        found.append(Finding(FAILURE, "unknown system", "system", len(wrong), f"{wrong[0]!r}", "use 'act' or 'sstl'"))
    return found


def _lead(values: Array) -> list[Finding]:
    """Return what is wrong with the lead of the screw, which is a label in numbers: NaN says "not given"."""
    given = values[~np.isnan(values)]
    found = _values(LEAD, given, 0, optional=True) if len(given) else []
    if not found and len(given) and (low := float(given.min())) != (high := float(given.max())):
        detail = f"{low:.6g} to {high:.6g} mm; the first value, {given[0]:.6g} mm, stands for the run"
        found.append(Finding(REMARK, "label changes within the run", LEAD, len(given), detail, "split the run, if the bend changed"))
    return found


def _values(name: str, values: Array, nulls: int, optional: bool) -> list[Finding]:
    found = []
    if nulls and not optional:
        found.append(Finding(FAILURE, "empty values", name, nulls, f"{nulls} of {len(values)}", "drop or repair these samples"))
    elif 0 < nulls < len(values) and name in OPTIONAL:
        found.append(Finding(REMARK, "partly empty", name, nulls, f"{nulls} of {len(values)}", "none needed"))
    if not nulls and within(values):
        return found + _tiny(name, values, len(values))
    nan = int(np.count_nonzero(np.isnan(values))) - nulls
    if nan > 0:
        found.append(Finding(FAILURE, "not a number", name, nan, f"{nan} of {len(values)}", "drop or repair these samples"))
    infinite = int(np.count_nonzero(np.isinf(values)))
    if infinite:
        found.append(Finding(FAILURE, "infinite values", name, infinite, f"{infinite} of {len(values)}", "repair the export"))
    absurd = int(np.count_nonzero(np.isfinite(values) & unsound(values)))
    if absurd:
        detail = f"{absurd} of {len(values)} over {LARGEST:.0e}, beyond any sensor or clock"
        found.append(Finding(FAILURE, "absurd values", name, absurd, detail, "repair the export, or check the unit"))
    return found + _tiny(name, values[~unsound(values)], len(values))


def _tiny(name: str, sound: Array, count: int) -> list[Finding]:
    """Return what is said of a tension that never leaves rounding, from its sound values."""
    said = too_small(name, sound) if name in TENSIONS else ""
    return [Finding(FAILURE, "absurd values", name, count, said, "check the unit")] if said else []


def _time(columns: dict[str, Array]) -> list[Finding]:
    time = columns["time_s"]
    if not within(time):
        time = time[~unsound(time)]
    if len(time) < 2:
        return []
    step = np.diff(time)
    least, most = float(step.min()), float(step.max())
    if FASTEST_S <= least == most:
        # nothing is wrong with an even clock: of many short runs most of the time was spent on it
        return []
    found = []
    if said := too_fast(time):
        found.append(Finding(FAILURE, "absurd sampling rate", "time_s", len(time), said, "check the unit"))
    for what, bad, mend in (
        ("time runs backwards", step < 0, partial(mend_backward, step, MIN_SAMPLES)),
        ("time repeats", step == 0, partial(mend_repeated, step, columns)),
    ):
        count = int(np.count_nonzero(bad))
        if count:
            first = int(np.argmax(bad)) + 1
            found.append(Finding(FAILURE, what, "time_s", count, f"first at sample {first}, {time[first]:.6g} s", mend()))
    forward = step[step > 0]
    if not len(forward):
        return found
    period = float(np.median(forward))
    gaps = int(np.count_nonzero(step > GAP_PERIODS * period))
    if gaps:
        what, detail, advice = gaps_of(columns, step, period)
        found.append(Finding(FAILURE, what, "time_s", gaps, detail, advice))
    count, short = _missed(time, step, period)
    if short:
        found.append(Finding(REMARK, "missing samples", "time_s", count, f"{short} short gaps", "none needed"))
    near = step[(step > 0) & (step < 1.5 * period)]
    jitter = 100.0 * float(np.std(near)) / period
    if jitter > 5.0:
        detail = f"{jitter:.0f} % of the period of {period:.4g} s"
        found.append(Finding(REMARK, "sampling jitter", "time_s", len(near), detail, "none needed"))
    return found


def _missed(time: Array, step: Array, period: float) -> tuple[int, int]:
    """Return the rows that are missing in short gaps, and the gaps.

    A row that is missing puts all stamps behind it late for good; a stamp that jitters is late by itself.
    """
    at = np.flatnonzero((step > 1.5 * period) & (step <= GAP_PERIODS * period))
    # between steady stamps a long step is a gap
    jitter = float(np.median(np.abs(step - period)))
    if float(np.mean(step < 0.0)) > MANY:
        # between rows out of order there are no gaps
        return 0, 0
    if not len(at) or jitter < STEADY * period or float(step.min()) <= 0.0:
        return int(np.sum(np.round(step[at] / period) - 1)), len(at)
    # over many stamps jitter is little, and a few rows that are missing move no median
    clock = float(np.median(time[FAR:] - time[:-FAR])) / FAR if len(time) > 2 * FAR else period
    off = time - clock * np.arange(len(time))
    late = [float(np.median(off[k + 1 : k + 1 + BESIDE]) - np.median(off[max(0, k + 1 - BESIDE) : k + 1])) for k in at]
    rows = [r for r in (round(v / period) for v in late) if r > 0]
    return sum(rows), len(rows)


def _signal(
    name: str, values: Array, reach: float, other: Array | None, grid: tuple[int, float], live: Live, period_s: float
) -> list[Finding]:
    span = float(np.ptp(values))
    n = len(values)
    if span == 0.0:
        return [Finding(FAILURE, "flat channel", name, n, f"always {values[0]:.6g} N", "check the sensor and the mapping")]
    found = []
    levels, grain = grid
    # far below the noise it is the last digit of a file that tells them apart
    if grain > 0.0 and filtering.noise_sd(values) < LEVELS * grain:
        # a channel that hardly moves shows few levels of any converter: the further one of the two tells how fine it is
        coarse = levels < LEVELS and reach < LEVELS * grain
        found.append(
            Finding(
                FAILURE if coarse else REMARK,
                "quantised",
                name,
                levels,
                f"{levels} levels, {grain:.3g} N apart",
                "record with more resolution" if coarse else "none needed",
            )
        )
    second = np.abs(np.diff(values, 2))[repeats.inside(values)[2:]]
    # a noise-free record holds its extremes; only where values seldom repeat does a repeated one tell
    if repeats.share(values) < STILL and len(second) and float(np.median(second)) > ROUNDING * span:
        for r in repeats.cut_off(values, other, live, name == TENSIONS[1], period_s):
            detail = f"{r.label} {r.level_n:.6g} N repeated, longest {r.longest} samples"
            found.append(Finding(FAILURE, "saturation", name, r.count, detail, "check the range of sensor and amplifier"))
        rests = repeats.frozen(values, live)
        if rests is not None and rests.longest >= STUCK_SAMPLES:
            detail = f"longest {rests.longest + 1} samples"
            found.append(Finding(FAILURE, "frozen stretches", name, rests.count, detail, "cut these stretches out"))
    spikes = int(np.count_nonzero(_spikes(values, live.step_n)))
    if spikes and (share := digits_lost(values)) > 0.0:
        detail = f"{100 * share:.0f} % of the samples are a tenth or a hundredth of their neighbours"
        found.append(Finding(FAILURE, "digits lost", name, spikes, detail, 'import with decimal = ","'))
    elif spikes:
        many, wild = spikes > MANY * n, impossible(values)
        lost = None if other is None else dropouts_of(values, other)
        fix = "check wiring and grounding" if many else "none needed: segment bridges single samples"
        said = "single samples off both neighbours"
        if lost is not None:
            # the rule ``filled`` tells them as well
            said, fix = f"{said}, {lost.samples} samples at {lost.level_n:.4g} N: readings that were missing", MEND
        if wild:
            said = (
                f"{said}, up to {float(np.max(np.abs(values))):.4g} N, which no tendon bears: {wild} numbers of another kind, such as dates"
            )
            fix = f"export anew, or {MEND}"
        found.append(Finding(FAILURE if many or wild else REMARK, "spikes", name, spikes, said, fix))
    return found


def _grain(values: Array) -> tuple[int, float]:
    """Return how many levels a channel takes and how far they are apart (N), 0 where they are no grid."""
    levels = np.unique(values)
    if not 1 < len(levels) < len(values) / 4:
        return len(levels), 0.0
    if len(levels) > 3:
        return len(levels), quantisation(values)
    # two levels, or three with one gap between them, are a converter's as well
    gaps = np.diff(levels)
    return len(levels), float(gaps.mean()) if float(np.ptp(gaps)) < EVEN * float(gaps.sum()) else 0.0


def _frozen(first: Array, second: Array, lives: tuple[Live, Live]) -> list[Finding]:
    """Both tensions unchanged together: a recorder that stopped, not a hold.

    Sensors with noise do not repeat their readings, so what repeats outside of the stretches is what says so.
    """
    same = (np.diff(first) == 0.0) & (np.diff(second) == 0.0)
    moves = ~lasting(same, STUCK_SAMPLES)
    again = max(float(np.mean(np.diff(v)[moves] == 0.0)) if moves.any() else 1.0 for v in (first, second))
    rests = repeats.frozen_together((first, second), lives)
    if again > STILL or rests is None or rests.longest < 3:
        return []
    said = f"both tensions, longest {rests.longest + 1} samples"
    if rests.longest < STUCK_SAMPLES:
        return [Finding(REMARK, "frozen stretches", "", rests.count, said, "none needed")]
    # a record without noise holds both; one in which either channel is told already needs no second finding
    told = min(float(np.mean(np.diff(v) == 0.0)) for v in (first, second)) < STILL
    if told or not all(noisy(v[np.append(True, moves)]) for v in (first, second)):
        return []
    return [Finding(FAILURE, "frozen stretches", "", rests.count, said, "cut these stretches out")]


def _spikes(values: Array, step_n: float) -> NDArray[np.bool_]:
    """Return the single samples that ``segment`` would bridge at a lower threshold, which noise alone does not reach, and such ends: to tell, as the diagnosis, which leaves samples out, asks ``recorder``.

    A spike returns: a sample to which the line through those on one side leads, or beyond it, is a corner or the last before a step.
    """
    found = np.zeros(len(values), np.bool_)
    second = np.abs(np.diff(values, 2))
    # a sensor that stands still says nothing of its noise
    lively = ~lasting(second == 0.0, STUCK_SAMPLES)
    # where noise crosses the edge between two levels a reading steps to and fro
    threshold = max(SPIKE_SPREADS * filtering.spread(second[lively] if lively.any() else second), ROUNDED * step_n)
    # without noise half of the differences vanish and give no measure
    if threshold == 0.0:
        return found
    found = np.asarray(filtering.despiked(np.ascontiguousarray(values), threshold) != values, np.bool_)
    v = values[2:-2]
    left, right = 2.0 * values[1:-3] - values[:-4], 2.0 * values[3:-1] - values[4:]
    up = v > values[1:-3]
    corner = np.where(up, v < np.maximum(left, right) + threshold, v > np.minimum(left, right) - threshold)
    found[2:-2] &= ~corner
    found[0], found[-1] = filtering.ends_off(values, threshold)
    return found


def _ordered(found: list[Finding], first: Array, second: Array, lives: tuple[Live, Live]) -> list[Finding]:
    """Return the findings with spikes told as rows out of order, where they are samples of another place in both channels."""
    a, b = (_spikes(v, live.step_n) for v, live in zip((first, second), lives, strict=True))
    both = a & b
    fewer, more = sorted((int(np.count_nonzero(a)), int(np.count_nonzero(b))))
    count = int(np.count_nonzero(both))
    # interference goes beyond what is measured, or meets one channel; a row of another place is a sound sample of both
    inside = all(v[~both].min() <= v[both].min() and v[both].max() <= v[~both].max() for v in (first, second)) if count else False
    if more <= MANY * len(a) or fewer < LEAST_SPIKES or count < 0.5 * fewer or not inside:
        return found
    detail = f"{count} rows stand off both neighbours in both channels at once, with values that fit elsewhere"
    said = Finding(FAILURE, "rows out of order", "", count, detail, "sort the rows by their clock or number (as numbers, not as text)")
    return [*(f for f in found if f.what != "spikes"), said]

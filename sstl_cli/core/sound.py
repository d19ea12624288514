"""What no recorder can have measured is set aside, and a run ends where its recorder paused: one rule for every command."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.aside import Aside, ledger
from sstl_cli.core.tables import PARAMETERS

if TYPE_CHECKING:
    from sstl_cli.core.runs import Run

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

REQUIRED = ("time_s", "tension_in_n", "tension_out_n")
TENSIONS = REQUIRED[1:]
OPTIONAL = ("position_in_mm", "tension_ref_n")
CHANNELS = REQUIRED + OPTIONAL
# in any unit a sensor or clock counts in: 32-bit counts reach 4.3e9, milliseconds since 1970 1.8e12
LARGEST = 1e15
SLOPES = PARAMETERS[0::2]
# a channel that never leaves this many of its unit holds rounding, not a measurement, nor has a loop such a slope in any two units
SMALLEST = 1e-12
FASTEST_S = 1e-9
# between the name of a run and the number of a piece of it
CUT = "~"
# a step longer than both ends a run
GAP_PERIODS = 10.0
LEAST_GAP_S = 1.0
# where bridging all shorter pauses would take more points of an even grid than this a sample, those end it too
MOST_BRIDGED = 10.0
LEAST_SAMPLES = 16
# steps of a clock looked at: all those of a long run would be a third more to hold
AT_ONCE = 65_536


def noted(run: Run) -> list[Run]:
    """Return the sound pieces of a run; what it loses is noted in the open ledger, or warned of where none is open."""
    pieces, aside = sound(run)
    note(aside)
    return pieces


def note(entries: Iterable[Aside]) -> None:
    """Note what is set aside in the open ledger; where none is open the caller's caller is warned."""
    book = ledger()
    if book is not None:
        book.add(entries)
        return
    for entry in entries:
        warnings.warn(f"set aside: {entry}", stacklevel=4)


def unsound(values: Array) -> Mask:
    """Return where values are not finite or beyond any sensor and clock, shape (n,)."""
    with np.errstate(invalid="ignore"):
        return np.asarray(~(np.abs(values) <= LARGEST))


def why_unsound(name: str, values: Array) -> dict[str, int]:
    """Return how many values of a column are unsound, by what is wrong with them.

    Examples
    --------
    >>> why_unsound("tension_in_n", np.array([1.0, np.nan, np.inf, 1e308]))
    {'not a number': 1, 'infinite': 1, 'beyond any sensor (over 1e+15)': 1}
    """
    absurd = f"beyond any {'clock' if name == 'time_s' else 'sensor'} (over {LARGEST:.0e})"
    counts = {
        "not a number": int(np.count_nonzero(np.isnan(values))),
        "infinite": int(np.count_nonzero(np.isinf(values))),
        absurd: int(np.count_nonzero(np.isfinite(values) & unsound(values))),
    }
    return {why: n for why, n in counts.items() if n}


def why_no_lines(row: Mapping[str, object]) -> dict[str, str]:
    """Return the slopes, biases, standard errors and lead of a row of Theta that no loop can have, each with the reason.

    Examples
    --------
    >>> why_no_lines({"gamma_p": 1e308, "beta_p": 0.2, "beta_r": None, "gamma_p_se": -0.1})
    {'gamma_p': 'is 1e+308, beyond any sensor', 'gamma_p_se': 'is a negative standard error'}
    >>> why_no_lines({"gamma_p": -1.0, "gamma_r": 5e-324})
    {'gamma_p': 'is -1, no slope of a loop, which rises', 'gamma_r': 'is 4.94e-324, no slope of a loop, which rises'}
    """
    found = {}
    for name in (*PARAMETERS, *(f"{p}_se" for p in PARAMETERS), "lead_mm"):
        value = row.get(name)
        if isinstance(value, float) and abs(value) > LARGEST:
            found[name] = f"is {value:.3g}, beyond any sensor"
        elif isinstance(value, float) and name in SLOPES and value < SMALLEST:
            found[name] = f"is {value:.3g}, no slope of a loop, which rises"
        elif isinstance(value, float) and name.endswith("_se") and value < 0.0:
            found[name] = "is a negative standard error"
    return found


def too_small(name: str, values: Array) -> str:
    """Return why a channel of finite values cannot be a measurement, else ''."""
    top = max(-float(values.min()), float(values.max())) if len(values) else 0.0
    return f"{name} never exceeds {top:.3g}, less than any sensor shows: is the unit right?" if 0.0 < top < SMALLEST else ""


def too_fast(time_s: Array) -> str:
    """Return why a clock cannot be a recorder's, else '' (also where it does not increase: that is another fault)."""
    step = time_s[1:] - time_s[:-1]
    least = float(step.min()) if len(step) else 0.0
    if least >= FASTEST_S or least <= 0.0:
        return ""
    return too_short(float(np.median(step)))


def too_short(period_s: float) -> str:
    """Return why a sampling period cannot be a recorder's, else ''."""
    return f"a sampling period of {period_s:.3g} s, faster than any recorder: is time_s in s?" if 0.0 < period_s < FASTEST_S else ""


def sound(run: Run) -> tuple[list[Run], list[Aside]]:
    """Return the pieces of a run that can have been recorded in one go, and what is set aside.

    Samples without a finite time, input and output go; a run no sensor can have given keeps none. The rest is cut at
    pauses (see :func:`cuts`); the first piece keeps the name, others are called ``name~2`` and so on; pieces of fewer
    than 16 samples go. Where time does not increase nothing is cut: that is for the caller to judge. Values of other
    channels that are not sound become NaN, which means "not measured"; a lead of the screw becomes None.
    """
    aside: list[Aside] = []
    total = len(run.time_s)
    run = _optional(run, aside)
    if total > 1 and _plain(run):
        return [run], aside
    lost = np.zeros(total, bool)
    reasons = []
    for name in REQUIRED:
        values = getattr(run, name)
        if not within(values):
            lost |= unsound(values)
            reasons += [f"{n} {why} in {name}" for why, n in why_unsound(name, values).items()]
    if reasons:
        run = run.cut(~lost)
        aside.append(Aside(run.run_id, int(np.count_nonzero(lost)), total, ", ".join(reasons)))
    small = [said for name in TENSIONS if (said := too_small(name, getattr(run, name)))]
    at = cuts(run.time_s)
    pieces = _split(run, at, total, aside) if len(at) else [run]
    for i, piece in enumerate(pieces):
        wrong = "; ".join([*small, *filter(None, [too_fast(piece.time_s)])])
        if wrong and len(piece):
            aside.append(Aside(piece.run_id, len(piece), total, wrong))
            pieces[i] = piece.cut(slice(0, 0))
    return pieces, aside


def within(values: Array) -> bool:
    """Return whether no value is unsound (see :func:`unsound`): two passes tell that all is well, and NaN wins both."""
    return not len(values) or bool(values.min() >= -LARGEST and values.max() <= LARGEST)


def _plain(run: Run) -> bool:
    """Whether the extremes alone tell that nothing is to be set aside or cut: most runs need no closer look."""
    time = run.time_s
    least, most = math.inf, 0.0
    for a in range(0, len(time) - 1, AT_ONCE):
        step = time[a + 1 : a + AT_ONCE + 1] - time[a : min(a + AT_ONCE, len(time) - 1)]
        # methods take half the time of np.min on the few samples of a short run; NaN fails every comparison
        low = float(step.min())
        if not low >= FASTEST_S:
            return False
        least, most = min(least, low), max(most, float(step.max()))
    # where the clock rises its ends bound it
    if not (most <= GAP_PERIODS * least and time[0] >= -LARGEST and time[-1] <= LARGEST):
        return False
    for name in TENSIONS:
        values = getattr(run, name)
        low, high = float(values.min()), float(values.max())
        if not (low >= -LARGEST and high <= LARGEST and max(-low, high) >= SMALLEST):
            return False
    return True


def cuts(time_s: Array) -> NDArray[np.intp]:
    """Return the first sample after each pause of an increasing clock (none where it does not increase).

    A pause is a step of more than 10 sampling periods (the median step) and 1 s; where an even grid over the shorter
    ones would still need more than 10 points a sample, 10 periods alone. Each stretch is looked at again with its own period.
    """
    found: list[int] = []
    waiting = [(0, len(time_s))]
    while waiting:
        a, b = waiting.pop()
        step = np.diff(time_s[a:b])
        if len(step) < 2:
            continue
        least, most = float(step.min()), float(step.max())
        if not least > 0.0 or most <= GAP_PERIODS * least:
            continue
        period = float(np.median(step))
        limit = max(GAP_PERIODS * period, LEAST_GAP_S)
        if float(np.sum(step[step <= limit])) > MOST_BRIDGED * period * len(step):
            limit = GAP_PERIODS * period
        at = (np.flatnonzero(step > limit) + 1 + a).tolist()
        if at:
            found += at
            edges = [a, *at, b]
            waiting += list(zip(edges[:-1], edges[1:], strict=True))
    return np.array(sorted(found), np.intp)


def _split(run: Run, at: NDArray[np.intp], total: int, aside: list[Aside]) -> list[Run]:
    edges = np.concatenate(([0], at, [len(run.time_s)]))
    longest = float(np.max(run.time_s[at] - run.time_s[at - 1]))
    short = np.diff(edges) < LEAST_SAMPLES
    kept = [run.cut(slice(int(a), int(b))) for a, b in zip(edges[:-1][~short], edges[1:][~short], strict=True)]
    dropped = int(np.diff(edges)[short].sum())
    pauses = f"{len(at)} pause{'s' if len(at) > 1 else ''}, the longest of {longest:.4g} s"
    aside.append(Aside(run.run_id, 0, total, f"cut at {pauses}, into {len(kept)} runs"))
    if dropped:
        why = f"{int(short.sum())} stretches of fewer than {LEAST_SAMPLES} samples between pauses"
        aside.append(Aside(run.run_id, dropped, total, why))
    if not kept:
        return [run.cut(slice(0, 0))]
    return [kept[0], *(replace(piece, run_id=f"{run.run_id}{CUT}{k}") for k, piece in enumerate(kept[1:], 2))]


def whole_of(run_id: str) -> str:
    """Return the name of the run that a piece was cut from at a pause; of a whole run its own.

    Examples
    --------
    >>> whole_of("monday~2"), whole_of("monday")
    ('monday', 'monday')
    """
    name, cut, number = run_id.rpartition(CUT)
    return name if cut and number.isdigit() else run_id


def _optional(run: Run, aside: list[Aside]) -> Run:
    lead = run.lead_mm
    if lead is not None and not abs(lead) <= LARGEST:
        if not math.isnan(lead):
            aside.append(Aside(run.run_id, 0, len(run.time_s), f"lead_mm is {lead:.3g}, taken as not given"))
        lead = None
    position, reference = (_measured(run, name, aside) for name in OPTIONAL)
    if lead is run.lead_mm and position is run.position_in_mm and reference is run.tension_ref_n:
        return run
    return replace(run, lead_mm=lead, position_in_mm=position, tension_ref_n=reference)


def _measured(run: Run, name: str, aside: list[Aside]) -> Array | None:
    """Return an optional channel, NaN where no sensor can have read it."""
    values: Array | None = getattr(run, name)
    if values is None:
        return None
    # NaN is no fault here: it says "not measured", and does not count among the extremes
    if np.fmin.reduce(values, initial=0.0) >= -LARGEST and np.fmax.reduce(values, initial=0.0) <= LARGEST:
        return values
    wrong = unsound(values) & ~np.isnan(values)
    n = int(np.count_nonzero(wrong))
    aside.append(Aside(run.run_id, n, len(values), f"infinite or beyond any sensor in {name}, taken as not measured"))
    return np.where(wrong, np.nan, values)

"""A position in another unit than mm, with which a rig (or one run beside the others) would be too stiff or too soft, or one that counts the wrong way, wraps around or stands still."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.core.units import UNITS
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.movement import unlike
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.repeated import ITS_OWN, copied_of
from sstl_cli.identification.gate.rules.unrelated import NOTHING, unexplained

RULE, RANK = "position", 80
# rigs of 0.1 to 100 N/mm are known; EA of 10 kN over 2 m is 5 N/mm
STIFF, SOFT = 800.0, 0.02
# correlation of position and input in every run: an elastic line has +1, which hysteresis and creep lower, but do not turn
AGAINST = -0.5
LENGTHS = {name: math.log(mm) for name, (kind, mm) in UNITS.items() if kind == "length" and name != "mm"}
# half of the smallest factor between two units of length, beyond which a run has another one than the others; bends of one rig are tens of percent apart
NEAR = 0.5 * min(abs(a - b) for a in (0.0, *LENGTHS.values()) for b in LENGTHS.values() if a != b)
# runs that agree before one of them can differ
FEW = 3
# how many times more of a position must be left by its own input than by that of another run, and by the one of the other
ANOTHERS = 2.0
# what an input leaves of a position from which on the two have nothing in common; friction, backlash and creep of a line leave half of it at the most
NOTHING_ALIKE = 0.7
# logarithm of what the stiffness of one rig varies by from run to run
ONE_RIG = 0.2
# time (s) and part of the range of tension for which a position stands still, where a tendon relaxes by less than that in a hold
STILL_S, STILL = 0.5, 0.5
# by how much (logarithm of the likelihood) one unit must be likelier than another to be named alone
LIKELIER = 2.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose tension over position no tendon has, or falls with it, and those whose position wraps around or stands still."""
    lost = [*_wrapped(log), *_resting(log)]
    yield from lost
    lost_in = {name for r in lost for name in r.run_ids}
    log = [e for e in log if e.run_id not in lost_in]
    moved = [e for e in log if e.tendon_like and e.loaded and math.isfinite(e.position_follows)]
    if moved and max(e.position_follows for e in moved) < AGAINST:
        worst = max(e.position_follows for e in moved)
        yield Remark(
            tuple(e.run_id for e in moved), RULE, "remark", worst, "1",
            f"{names([e.run_id for e in moved])}: the tension falls as the position rises in every run (correlation {worst:.2f} or less), where "
            "a line that is pulled grows longer; the position probably counts the wrong way, or is that of the other end",
            "position_in_mm = { column = ..., sign = -1 }",
        )  # fmt: skip
    copied = list(copied_of(moved))
    yield from copied
    moved = [e for e in moved if not any(e.run_id in r.run_ids for r in copied)]
    foreign = list(_foreign(moved))
    yield from foreign
    moved = [e for e in moved if not any(e.run_id in r.run_ids for r in foreign)]
    alone = list(_apart(moved))
    yield from alone
    told = {name for r in alone for name in r.run_ids}
    for stiff in (True, False):
        hit = [
            e
            for e in log
            if e.run_id not in told
            and e.tendon_like
            and e.loaded
            and _stiffness(e) > 0.0
            and (_stiffness(e) > STIFF if stiff else _stiffness(e) < SOFT)
        ]
        if hit:
            k = _stiffness(hit[0])
            unit = "m" if stiff else "um"
            # an encoder has many counts a millimetre, as there are many um
            counts = "" if stiff else ", or in counts of an encoder"
            scaled = "" if stiff else ' or position_in_mm = { column = ..., unit = "counts", gain = (mm per count) }'
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "remark", k, "N/mm",
                f"{names([e.run_id for e in hit])}: tension over position is {k:.3g} N/mm, where tendons have 0.1 to 100; the "
                f"position is probably in {unit}, not mm{counts}",
                f'position_in_mm = {{ column = ..., unit = "{unit}" }}{scaled}',
            )  # fmt: skip


def _wrapped(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose position goes over from one end of its range to the other, as no line does."""
    hit = [e for e in log if e.tendon_like and math.isfinite(e.position_wrap_mm)]
    if hit:
        ids, size = tuple(e.run_id for e in hit), max(e.position_wrap_mm for e in hit)
        yield Remark(
            ids, RULE, "remark", size, "mm",
            f"{names(ids)}: the position jumps by {size:.4g} mm from one end of its range to the other in one sample while the tension goes on; the counter of the "
            "encoder probably wraps around",
            "position_in_mm = { column = (exported anew, with the turns counted) }, or no position_in_mm",
        )  # fmt: skip


def _resting(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose position stands still while the tension moves: a line of any stiffness grows longer."""
    still = [(e, r) for e in log if e.tendon_like and e.loaded and (r := e.position_rest) is not None]
    whole = [(e, r) for e, r in still if e.position_span_mm == 0.0]
    part = [(e, r) for e, r in still if r.fine and r.length_s >= STILL_S and r.moved_n > STILL * e.ranges[0].span]
    for hit, how in ((whole, "never changes"), (part, "stands still")):
        if hit:
            ids, r = tuple(e.run_id for e, _ in hit), max((r for _, r in hit), key=lambda r: r.moved_n)
            where = "" if hit is whole else f" for {r.length_s:.3g} s from {r.at_s:.4g} s on"
            yield Remark(
                ids, RULE, "remark", r.moved_n, "N",
                f"{names(ids)}: the position {how}{where} while the tension moves by {r.moved_n:.3g} N, and a line that is pulled grows longer; the encoder is probably "
                "stuck or not connected, or it is that of an end that is held",
                "position_in_mm = { column = (another column) }, or no position_in_mm",
            )  # fmt: skip


def _stiffness(e: Evidence) -> float:
    return e.ranges[0].span / e.position_span_mm if e.position_span_mm > 0.0 else 0.0


def _foreign(moved: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the run whose position goes the way of another run's input, as near as positions go in this log, and not that of its own."""
    log = [e for e in moved if e.position_movement.means]
    if len(log) <= FEW:
        return
    own = {e.run_id: unlike(e.position_movement, e.movement) for e in log}
    worst = max(log, key=lambda e: own[e.run_id])
    most = max(own[e.run_id] for e in log if e is not worst)
    left, other = min(((unlike(worst.position_movement, o.movement), o) for o in log if o is not worst), key=lambda pair: pair[0])
    # what a line's own creep and backlash leave of any run is no sign of this one
    usual = float(np.median([own[e.run_id] for e in log if e is not worst]))
    if own[worst.run_id] < ANOTHERS * usual:
        return
    # a run that moves as its own does fits it as well, and tells nothing
    apart = unlike(worst.movement, other.movement)
    said = f"{names([worst.run_id])}: the input leaves {100 * own[worst.run_id]:.0f} % of the position's movement unexplained (at most {100 * most:.0f} % in the other runs)"
    if left <= most and ANOTHERS * left < min(own[worst.run_id], apart):
        said += f", that of run {other.run_id} {100 * left:.0f} %; it is probably the position of another run"
    elif own[worst.run_id] > max(NOTHING_ALIKE, ANOTHERS * most) and worst.position_follows > AGAINST and not unexplained(worst) > NOTHING:
        # friction explains the tensions, so that it is the position that is not theirs, and one that counts the other way follows as well
        said += ", and friction explains the output by it; it is probably the position of another run, or on another clock"
    else:
        return
    yield Remark(
        (worst.run_id,), RULE, "remark", 100.0 * own[worst.run_id], "%",
        said,
        ITS_OWN,
    )  # fmt: skip


def _apart(moved: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose position goes another way, or by another unit, than that of most runs of the system (of the log, where these are few)."""
    for system in dict.fromkeys(e.system for e in moved):
        own = [e for e in moved if e.system == system]
        beside = own if len(own) >= FEW else list(moved)
        # where position and tension do not belong together, neither way nor size means anything
        sure = [e for e in beside if abs(e.position_follows) > -AGAINST and _stiffness(e) > 0.0]
        if len(sure) < FEW:
            continue
        yield from _turned([e for e in own if e in sure], sure)
        yield from _scaled([e for e in own if e in sure], sure)


def _turned(own: list[Evidence], beside: list[Evidence]) -> Iterator[Remark]:
    """Yield the runs of few that count against the rest."""
    hit = [e for e in own if e.position_follows < AGAINST]
    if hit and 2 * sum(e.position_follows < AGAINST for e in beside) < len(beside):
        worst = max(e.position_follows for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", worst, "1",
            f"{names([e.run_id for e in hit])}: the tension falls as the position rises (correlation {worst:.2f} or less), where it rises with it in "
            "the other runs; the position probably counts the wrong way here",
            "position_in_mm = { column = ..., sign = -1 } (for this file)",
        )  # fmt: skip


def _scaled(own: list[Evidence], beside: list[Evidence]) -> Iterator[Remark]:
    """Yield the runs that are as much stiffer or softer than most as another unit of length makes them."""
    usual = float(np.median([math.log(_stiffness(e)) for e in beside]))
    rest = [e for e in beside if abs(math.log(_stiffness(e)) - usual) < NEAR]
    if 2 * len(rest) <= len(beside):
        return
    hits: dict[int, list[tuple[float, Evidence]]] = {}
    for e in own:
        if e not in rest:
            # the same bend in the same system has the same stiffness, in the other system nearly so
            alike = (
                [o for o in rest if (o.config_id, o.system) == (e.config_id, e.system)] or [o for o in rest if o.system == e.system] or rest
            )
            off = math.log(_stiffness(e)) - float(np.median([math.log(_stiffness(o)) for o in alike]))
            hits.setdefault(round(off / NEAR), []).append((off, e))
    for hit in hits.values():
        off = float(np.median([v for v, _ in hit]))
        units = sorted(LENGTHS, key=lambda name: abs(LENGTHS[name] - off))
        # the factor is known to what the stiffness of one rig varies by
        error = min(max(ONE_RIG, *(abs(math.log(_stiffness(o)) - usual) for o in rest)), NEAR)
        nearest = abs(LENGTHS[units[0]] - off)
        if nearest > error:
            # runs of other bends or other loads may be softer: that alone is no slip
            continue
        likely = [name for name in units if (LENGTHS[name] - off) ** 2 - nearest**2 < 2.0 * LIKELIER * (0.5 * error) ** 2]
        ids = tuple(e.run_id for _, e in hit)
        yield Remark(
            ids, RULE, "remark", math.exp(off), "1",
            f"{names(ids)}: tension over position is {_stiffness(hit[0][1]):.3g} N/mm, {math.exp(off):.3g} times that of the other runs; "
            f"the position is probably in units of {' or '.join(map(repr, likely))} here, not mm",
            " or ".join(f'position_in_mm = {{ column = ..., unit = "{name}" }}' for name in likely) + " (for this file)",
        )  # fmt: skip

"""Two rigs under one set of labels: every bend has its runs twice, and the one kind rubs more than the other, by the same factor or in the runs that come later or have other sensors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

Array = NDArray[np.float64]
RULE, RANK = "two_rigs", 48
# factor between the two kinds that friction of one rig does not reach from run to run, and how well the cells must agree on it (part of its logarithm)
FACTOR, AGREE = 1.25, 0.25
# in one system alone: the factor that counts
ALONE = 1.4
# of the logarithm: how far friction of two passes may be from twice that of one, by the errors of both and the sheath's ends; and what the
# friction of a pulley may leave of what a factor alone leaves
TWO, PULLEY = 0.07, 0.5
# cells (bend, system, movement) with both kinds that tell, and systems: a wrong label of the system makes a factor in one of them only
CELLS, SYSTEMS = 3, 2
# cells in all of which the runs of one kind come later in the log, by chance once in 2**(n - 1)
IN_ORDER = 5
# factor between steps of converters, or noises of the input, of two recorders: an output that rubs more may have another noise by itself
OTHER, SENSED = 1.2, ((0, "step_n"), (1, "step_n"), (0, "noise_n"))
# factor between the white noises of both sensors, which no movement makes
BOTH = 2.0


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the runs of the rig that rubs more."""
    hit, factors = second_rig(log)
    if hit:
        factor, least, most = (float(v) for v in np.quantile(factors, [0.5, 0.0, 1.0]))
        times = f"{factor:.3g}" if most < least * FACTOR else f"{least:.3g} to {most:.3g}"
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", factor, "1",
            f"{names([e.run_id for e in hit])}: friction is {times} times that of the other runs of the same bend and system, "
            f"in every bend{' and in both systems' if len({e.system for e in hit}) > 1 else ''}; two rigs (or two sheaths) are probably under one set "
            "of labels",
            "import the two groups into logs of their own",
        )  # fmt: skip


def second_rig(log: Sequence[Evidence]) -> tuple[list[Evidence], list[float]]:
    """Return the runs that rub more than others of their cell, and the factors of all cells; none where these are neither one nor in runs that differ by more."""
    known = [e for e in log if e.config_id is not None and e.wrap > 0.0]
    both = _cells(known, moving=True)
    alike = len(both) >= CELLS
    # movements of their own rub by themselves: then the recorder must be another one as well
    both = both if alike else _cells(known, moving=False)
    alone = len({c[0].system for c in both}) < SYSTEMS
    if len(both) < CELLS:
        return [], []
    low, high = [], []
    for cell in both:
        at = 1 + int(np.argmax(np.diff(np.log([e.wrap for e in cell]))))
        low.append(cell[:at])
        high.append(cell[at:])
    rubs = [np.array([float(np.mean(np.log([e.wrap for e in runs]))) for runs in kind]) for kind in (low, high)]
    gaps = rubs[1] - rubs[0]
    usual = float(np.median(gaps))
    apart = usual > math.log(ALONE if alone else FACTOR)
    if alone and apart:
        apart = not second_pass(np.exp(rubs[0]), np.exp(rubs[1]), np.zeros(len(both)))
    same = float(np.max(np.abs(gaps - usual))) < AGREE * usual or (
        float(np.min(gaps)) > math.log(FACTOR) and (_in_order(low, high, log) or _sensed(low, high))
    )
    # where both sensors are others, one bend may tell its friction badly; noise alone may be that of the drive, which one movement lacks
    same |= float(np.min(gaps)) > 0.0 and _both_sensed(low, high)
    apart &= alike or _sensed(low, high)
    return ([e for runs in high for e in runs], np.exp(gaps).tolist()) if apart and same else ([], [])


def _cells(known: Sequence[Evidence], moving: bool) -> list[list[Evidence]]:
    """Return the runs of each bend and system (and movement, where ``moving``) that has several, by their friction."""
    cells: dict[object, list[Evidence]] = {}
    for e in known:
        cells.setdefault((e.config_id, e.location, e.system, e.trajectory if moving else None, e.tendon), []).append(e)
    return [sorted(c, key=lambda e: e.wrap) for c in cells.values() if len(c) > 1]


def _in_order(low: list[list[Evidence]], high: list[list[Evidence]], log: Sequence[Evidence]) -> bool:
    """Whether the runs that rub more are the later ones in every cell, or the earlier ones: shuffled labels leave what they rub in all alike."""
    place = {e.run_id: i for i, e in enumerate(log)}
    at = [([place[e.run_id] for e in a], [place[e.run_id] for e in b]) for a, b in zip(low, high, strict=True)]
    return len(at) >= IN_ORDER and (all(max(a) < min(b) for a, b in at) or all(max(b) < min(a) for a, b in at))


def _sensed(low: list[list[Evidence]], high: list[list[Evidence]]) -> bool:
    """Whether the recorder of all runs that rub more is another one than that of all others."""
    readings = [[[float(getattr(e.sensors[i], name)) for runs in kind for e in runs] for kind in (low, high)] for i, name in SENSED]
    rates = [[e.dt_s for runs in kind for e in runs] for kind in (low, high)]
    return any(_apart(a, b, OTHER) for a, b in (*readings, rates))


def _both_sensed(low: list[list[Evidence]], high: list[list[Evidence]]) -> bool:
    """Whether both sensors of all runs that rub more have white noise of another size than those of all others."""
    one, other = ([e.sensors for runs in kind for e in runs] for kind in (low, high))
    white = all(s.fine for pair in (*one, *other) for s in pair)
    return white and all(_apart([pair[i].noise_n for pair in one], [pair[i].noise_n for pair in other], BOTH) for i in (0, 1))


def recorders_differ(first: Sequence[Evidence], second: Sequence[Evidence]) -> list[str]:
    """Return in what the recorders of two groups of runs differ, nothing where they may be one: every run of the one from every run of the other."""
    white = all(s.fine for e in (*first, *second) for s in e.sensors)
    noises = [([e.sensors[i].noise_n for e in first], [e.sensors[i].noise_n for e in second]) for i in (0, 1)]
    found = ["rate"] if _apart([e.dt_s for e in first], [e.dt_s for e in second], OTHER) else []
    return [*found, "noise of both sensors"] if white and all(_apart(a, b, BOTH) for a, b in noises) else found


def _apart(a: Sequence[float], b: Sequence[float], factor: float) -> bool:
    """Whether all of the one are larger than all of the other by a factor."""
    return min(b) > factor * max(a) or min(a) > factor * max(b)


def second_pass(low: Array, high: Array, errors: Array) -> bool:
    """Return whether two kinds of runs differ by a second pass in every bend: twice the friction, and that of a pulley, alike in all bends.

    ``low`` and ``high`` are n theta of both kinds, ``errors`` those of the logarithm of their ratio, shape (n,). Of two rigs the one rubs more by
    a factor of its own.
    """
    ratios = np.log(high / low)
    if bool(np.all(np.abs(ratios - math.log(2.0)) < np.maximum(TWO, errors))):
        return True
    # what a pulley adds is told from a factor where bends differ
    added = high - 2.0 * low
    spread = float(np.ptp(added)) / float(np.max(high))
    return len(low) > 1 and float(np.min(added / high)) > -TWO and spread < TWO and spread < PULLEY * float(np.ptp(ratios))

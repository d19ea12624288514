"""Shuffled labels: act and sstl (or two trajectories) disagree on which bend rubs more."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from sstl_cli.identification.gate.bounds import ABOVE, bounds, flipped_fits, turned, widest
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.two_rigs import second_rig
from sstl_cli.identification.gate.scatter import friction_errors

RULE, RANK = "labels", 55
Column = tuple[str, str | None, str | None]
# friction of two bends is in the same order under every law: difference of ln friction that counts, and that leaves no doubt
TURNED, CERTAIN = 0.04, 0.15
# and where each bend has a movement of its own, which rubs by itself
MOVED_TURNED = 0.25
ERRORS = 4.0
CELL = 0.12
# spreads of friction from run to run (wear, lubrication) that a cell's runs must be apart by, and part (logarithm) by which they are where no other bend of the log rubs as the odd
# one does; expected range of so many draws over their spread
SCATTERS, NO_BEND = 3.5, 0.3
DRAWS = (1.0, 1.0, 1.13, 1.69, 2.06, 2.33, 2.53)
# runs beyond which leaving one out leaves enough to be compared
FEW = 4


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose configuration label contradicts the friction they show."""
    known = [e for e in log if e.slopes.known and e.config_id is not None and e.slopes.friction > 0.05]
    if second_rig(log)[0]:
        return
    said = list(_contradictions(known))
    alone = [e for e in known if not any(_contradictions([o for o in known if o is not e]))] if said and len(known) > FEW else []
    if len(alone) > 1:
        # the order of bends may hold without either of two runs: the one that leaves its own configuration is it
        away = [e for e in alone if _away(e, known) > CELL]
        alone = away if len(away) == 1 else alone
    if len(alone) == 1:
        # one label explains all of it
        yield _single(alone[0], [e for e in known if e is not alone[0]])
    else:
        # what lines tell is finer than what laws allow
        places = {(e.location, e.tendon) for e in log} if not said else set()
        yield from said
        for where in places:
            yield from _disordered([e for e in log if (e.location, e.tendon) == where])


def _disordered(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Compare which of two bends rubs more in every system and movement, by all that sound laws allow of their friction."""
    known: dict[tuple[str, tuple[str, str | None]], list[Evidence]] = {}
    for e in log:
        if e.config_id is not None and e.tendon_like and e.usable and math.isfinite(bounds(e)[0]):
            known.setdefault((str(e.config_id), (e.system, e.trajectory)), []).append(e)
    cells = {at: widest([bounds(e) for e in runs]) for at, runs in known.items()}
    varies = [abs(math.log(b.wraps[0] / a.wraps[0])) for runs in known.values() for a, b in pairwise(runs)]
    found = turned(cells, max(ABOVE, ERRORS * float(np.median(varies))) if len(varies) > 1 else ABOVE)
    if not found or flipped_fits(cells):
        return
    first, second, apart, ups, downs = max(found, key=lambda t: t[2])
    # of two systems either may hold the labels, however many movements of each tell
    one_system = {c[0] for c in ups} & {c[0] for c in downs}
    fewer = min(ups, downs, key=len) if one_system and len(ups) != len(downs) else ups + downs
    hit = [e for (k, c), runs in known.items() if c in fewer and k in {k for t in found for k in t[:2]} for e in runs]
    which = " and ".join(sorted({e.system for e in hit}))
    yield Remark(
        tuple(e.run_id for e in hit), RULE, "failure", 100.0 * math.expm1(apart), "%",
        f"{names([e.run_id for e in hit])}: of configurations {first} and {second} the one rubs more in {_called(ups)} and the other in {_called(downs)}, by {100.0 * math.expm1(apart):.0f} % "
        f"or more under every law of friction that explains the runs; configuration labels of {which} runs are probably shuffled or exchanged",
        "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
    )  # fmt: skip


def _called(columns: list[tuple[str, str | None]]) -> str:
    return ", ".join(" ".join(part for part in c if part) for c in columns)


def _own(e: Evidence, runs: list[Evidence]) -> list[float]:
    """Return the friction that the other runs of a run's configuration and system show, in whatever movement."""
    return [
        o.slopes.friction
        for o in runs
        if o is not e and (o.config_id, o.system, o.tendon, o.location) == (e.config_id, e.system, e.tendon, e.location)
    ]


def _away(e: Evidence, runs: list[Evidence]) -> float:
    """Return how far (logarithm) a run's friction is from that of the others of its configuration, 0 where there are none."""
    own = _own(e, runs)
    return abs(math.log(e.slopes.friction / float(np.median(own)))) if own else 0.0


def _single(e: Evidence, rest: list[Evidence]) -> Remark:
    """Return what is said of the one run without whose label all others agree."""
    own = _own(e, rest)
    bends: dict[str, list[float]] = {}
    for o in rest:
        if (o.system, o.tendon, o.location) == (e.system, e.tendon, e.location) and o.config_id != e.config_id:
            bends.setdefault(str(o.config_id), []).append(o.slopes.friction)
    near = [k for k, v in bends.items() if abs(math.log(e.slopes.friction / float(np.median(v)))) < CELL]
    away = _away(e, rest) if own else CERTAIN
    others = f" where the other runs of {e.config_id} show {float(np.median(own)):.2f}" if own else ""
    fits = f", and that of {near[0]} fits" if len(near) == 1 else ""
    return Remark(
        (e.run_id,), RULE, "failure" if away > CERTAIN else "remark", 100.0 * math.expm1(away), "%",
        f"{names([e.run_id])}: labelled configuration {e.config_id}, but it rubs n theta = {e.slopes.friction:.2f}{others}; without this run all "
        f"others agree, so that its configuration label is probably wrong{fits}",
        "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
    )  # fmt: skip


def _contradictions(known: list[Evidence]) -> Iterator[Remark]:
    """Yield what labels contradict in the friction of these runs."""
    yield from _cells(known)
    places: dict[object, list[Evidence]] = {}
    for e in known:
        places.setdefault(e.location, []).append(e)
    groups = [g for g in places.values() if len({e.config_id for e in g}) > 1]
    for group in groups or [known]:
        bends: dict[Column, set[str]] = {}
        for e in group:
            bends.setdefault(_column(e), set()).add(str(e.config_id))
        yield from _columns(group, moving=any(len(b) > 1 for b in bends.values()))


def _column(e: Evidence, moving: bool = True) -> Column:
    return e.system, e.trajectory if moving else None, e.tendon


def _log(runs: list[Evidence]) -> float:
    return float(np.log(np.median([e.slopes.friction for e in runs])))


def _scatter(cells: Sequence[Sequence[Evidence]]) -> float:
    """Return by how much (logarithm) friction varies from run to run of one configuration, system and movement, 0 where nothing was repeated.

    Wear and lubrication vary all of them; a wrong label is in few, so that the lower median of these cells does not know of it.
    """
    spreads = sorted(_spread(c) for c in cells)
    return spreads[(len(spreads) - 1) // 2] if spreads else 0.0


def _spread(cell: Sequence[Evidence]) -> float:
    logs = np.log([e.slopes.friction for e in cell])
    return float(np.ptp(logs)) / DRAWS[min(len(cell), len(DRAWS) - 1)]


def _repeated(known: Sequence[Evidence]) -> list[list[Evidence]]:
    """Return the runs of every configuration, system and movement that was recorded again."""
    cells: dict[object, list[Evidence]] = {}
    for e in known:
        if e.trajectory is not None:
            cells.setdefault((e.config_id, e.location, *_column(e)), []).append(e)
    return [c for c in cells.values() if len(c) > 1]


def _columns(group: list[Evidence], moving: bool) -> Iterator[Remark]:
    """Compare which of two configurations rubs more, in every column (system, trajectory where ``moving``, tendon) that has both."""
    turned = TURNED if moving else MOVED_TURNED
    cells: dict[tuple[str, Column], list[Evidence]] = {}
    for e in group:
        cells.setdefault((str(e.config_id), _column(e, moving)), []).append(e)
    columns = sorted({c for _, c in cells}, key=str)
    # gains are those of the sensors, which all movements of a system share
    sensed = {(e.system, e.tendon) for e in group}
    error = {name: v for key in sensed for name, v in friction_errors([e for e in group if (e.system, e.tendon) == key]).items()}
    repeated = _repeated(group)
    # one cell alone may hold the wrong label
    scatter = _scatter(repeated) if len(repeated) > 1 else 0.0
    suspects: dict[str, Evidence] = {}
    worst, against = 0.0, ("", "")
    level = {at: _log(runs) for at, runs in cells.items()}
    errors_at = {at: max(error[e.run_id] / e.slopes.friction for e in runs) for at, runs in cells.items()}
    for first, second in _turned(sorted({k for k, _ in cells}), columns, level, errors_at, turned):
        both = [c for c in columns if (first, c) in cells and (second, c) in cells]
        steps = [level[second, c] - level[first, c] for c in both]
        errors = [_error([cells[k, c] for k in (first, second)], error, scatter) for c in both]
        rising = [c for c, d, s in zip(both, steps, errors, strict=True) if d > max(turned, ERRORS * s)]
        falling = [c for c, d, s in zip(both, steps, errors, strict=True) if d < -max(turned, ERRORS * s)]
        if not rising or not falling:
            continue
        apart = max(steps) - min(steps)
        if apart > worst:
            worst, against = apart, (first, second)
        fewer = min(rising, falling, key=len) if len(rising) != len(falling) else rising + falling
        suspects.update({e.run_id: e for c in fewer for k in (first, second) for e in cells[k, c]})
    if not suspects:
        return
    ids = tuple(suspects)
    which = " and ".join(sorted({e.system for e in suspects.values()}))
    yield Remark(
        ids, RULE, "failure" if worst > CERTAIN else "remark", 100.0 * worst, "%",
        f"{names(ids)}: of configurations {against[0]} and {against[1]} the one rubs more in these runs and the other in the "
        f"rest ({100 * worst:.0f} % apart); the files or configuration labels of {which} runs are probably shuffled",
        "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
    )  # fmt: skip


def _error(cells: Sequence[Sequence[Evidence]], error: Mapping[str, float], scatter: float) -> float:
    """Return the error (logarithm) of a step from one cell to another: that of the lines, and what friction varies by from run to run."""
    lines = max(error[e.run_id] / e.slopes.friction for runs in cells for e in runs)
    return math.hypot(lines, scatter * math.sqrt(sum(1.0 / len(runs) for runs in cells)))


def _turned(
    bends: list[str],
    columns: list[Column],
    level: Mapping[tuple[str, Column], float],
    error: Mapping[tuple[str, Column], float],
    least: float,
) -> Iterator[tuple[str, str]]:
    """Yield the pairs of configurations that are worth a look: one seems to rub more in one column, and the other in another.

    Of a thousand configurations half a million pairs are compared, a row of them at once. ``error`` is that of each cell.
    """
    friction = np.array([[level.get((k, c), math.nan) for c in columns] for k in bends])
    # an error that is not known asks for a closer look
    sure = np.nan_to_num(np.array([[error.get((k, c), 0.0) for c in columns] for k in bends]), posinf=0.0)
    for i in range(len(bends) - 1):
        step = friction[i + 1 :] - friction[i]
        far = np.maximum(least, ERRORS * np.maximum(sure[i + 1 :], sure[i]))
        doubt = np.any(step > far, axis=1) & np.any(step < -far, axis=1)
        yield from ((bends[i], bends[i + 1 + j]) for j in np.flatnonzero(doubt).tolist())


def _cells(known: list[Evidence]) -> Iterator[Remark]:
    """Compare runs that claim the same configuration, system and trajectory."""
    repeated = _repeated(known)
    for runs in repeated:
        logs = np.log([e.slopes.friction for e in runs])
        apart = float(np.ptp(logs))
        error = max(e.slopes.friction_se / e.slopes.friction for e in runs)
        if apart < max(CELL, ERRORS * 1.5 * error):
            continue
        far = np.abs(logs - np.median(logs))
        off = [e for e, d in zip(runs, far, strict=True) if d > 0.5 * apart]
        rest = [e for e in runs if e not in off]
        usual = max(_scatter([c for c in repeated if c is not runs]), _spread(rest) if 1 < len(rest) < len(runs) else 0.0)
        if apart < SCATTERS * usual or (apart < NO_BEND and not _fits_elsewhere(runs, known)):
            continue
        # as many runs of the configuration, in other movements, may rub as the odd one does: then it is not the odd one
        backed = len(runs) > 2 and len(off) == 1 and len(_like(off[0], known)) + 1 >= len(runs) - 1
        ids = tuple(e.run_id for e in runs if len(runs) < 3 or backed or e in off)
        yield Remark(
            ids, RULE, "remark", 100.0 * apart, "%",
            f"{names(ids)}: runs labelled configuration {runs[0].config_id} ({runs[0].system}, {runs[0].trajectory}) differ by "
            f"{100 * apart:.0f} % in friction; {_which(off[0], runs, known) if backed else 'one of them probably belongs to another configuration'}",
            "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
        )  # fmt: skip


def _fits_elsewhere(cell: list[Evidence], known: list[Evidence]) -> bool:
    """Whether the friction of one end of a cell is that of another configuration of its system, as a wrong label leaves it."""
    own = cell[0]
    bends: dict[str | None, list[float]] = {}
    for o in known:
        if (o.system, o.tendon, o.location) == (own.system, own.tendon, own.location) and o.config_id != own.config_id:
            bends.setdefault(o.config_id, []).append(o.slopes.friction)
    levels = [float(np.median(v)) for v in bends.values()]
    ends = [f(e.slopes.friction for e in cell) for f in (min, max)]
    return any(abs(math.log(end / level)) < 0.5 * CELL for end in ends for level in levels)


def _like(e: Evidence, known: list[Evidence]) -> list[Evidence]:
    """Return the other runs of a run's configuration and system that rub as it does."""
    own = [
        o for o in known if o is not e and (o.config_id, o.system, o.tendon, o.location) == (e.config_id, e.system, e.tendon, e.location)
    ]
    return [o for o in own if abs(math.log(o.slopes.friction / e.slopes.friction)) < CELL]


def _which(odd: Evidence, runs: list[Evidence], known: list[Evidence]) -> str:
    """Return which runs rub alike where two groups are as likely to be the other configuration's."""
    beside = names([odd.run_id, *(o.run_id for o in _like(odd, known))])
    rest = [e for e in runs if e is not odd]
    there = float(np.median([e.slopes.friction for e in rest]))
    return (
        f"n theta is {odd.slopes.friction:.2f} in {beside} and {there:.2f} in {names([e.run_id for e in rest])}, so that one of the two groups probably belongs to another "
        "configuration or rig"
    )

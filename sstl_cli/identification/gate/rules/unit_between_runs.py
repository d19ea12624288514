"""One run in another unit than the others: noise and range of both channels are scaled by the same factor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import FORCES, or_gain, stated

RULE, RANK = "unit_between_runs", 8
# of the logarithms: noise is known to a few per cent, ranges depend on the movement
NOISE, RANGE = 0.2, 0.5
# part of the least noise of a channel that it does not fall below in another run
QUIET = 0.6
# of the logarithm: the output's range, which the bend changes as well
BENDS = 1.2
# of the logarithms: steps of one converter, input ranges of one movement, and noise beside such a range
STEP, SAME, SENSED = 0.05, 0.04, 0.6


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that are a unit of force away from the rest of their system."""
    found: dict[str, list[tuple[Evidence, float]]] = {}
    usable = [e for e in log if e.tendon_like and all(s.step_n > 0.0 or (s.noise_n > 0.0 and s.white) for s in e.sensors)]
    for system in sorted({e.system for e in usable}):
        alike = [e for e in usable if e.system == system]
        # sensors of two systems are often of one kind, and better than no comparison
        runs = alike if len(alike) > 2 else usable
        if len(runs) < 3:
            continue
        sizes = np.log(_sizes(runs))
        usual = sizes[_usual(sizes)]
        for e, row in zip(runs, sizes, strict=True):
            unit = _unit(row - usual) if e.system == system else None
            if unit is not None and (runs is alike or not _one_converter(e, log)):
                # noise is known better than what the movement makes of a range
                found.setdefault(unit, []).append((e, float(np.mean((row - usual)[:2]))))
    told = {e.run_id for hit in found.values() for e, _ in hit}
    for e, unit, size in _by_movement([e for e in log if e.run_id not in told]):
        found.setdefault(unit, []).append((e, size))
    for unit, hit in found.items():
        ids = tuple(e.run_id for e, _ in hit)
        factor = math.exp(float(np.median([size for _, size in hit])))
        either = or_gain(factor, max(r.high for e, _ in hit for r in e.ranges))
        mend = f"{stated(0, unit)}; {stated(1, unit)} (for this file)"
        if either:
            mend += f", or {'; '.join(stated(i, 'counts', f', gain = {1.0 / factor:.4g}') for i in (0, 1))}"
        yield Remark(
            ids, RULE, "failure", factor, "1",
            f"{names(ids)}: noise and range of both channels are {factor:.3g} times those of the other runs; this "
            f"file is probably in {unit} (which makes {1.0 / FORCES[unit]:.3g}){either}, the others in N",
            mend,
        )  # fmt: skip


def _sizes(runs: Sequence[Evidence]) -> list[tuple[float, float, float, float]]:
    """Return noise and range of both channels; a step that all runs show is known better than their noise."""
    stepped = [all(e.sensors[i].step_n > 0.0 for e in runs) for i in (0, 1)]

    def size(e: Evidence, i: int) -> float:
        s = e.sensors[i]
        return s.step_n if stepped[i] else max(s.noise_n, 0.3 * s.step_n)

    return [(size(e, 0), size(e, 1), max(e.ranges[0].span, 1e-300), max(e.ranges[1].span, 1e-300)) for e in runs]


def _one_converter(e: Evidence, log: Sequence[Evidence]) -> bool:
    """Whether other runs of the system show the quantisation step of this one: then all are in one unit."""
    others = [o for o in log if o is not e and o.system == e.system and o.tendon_like]
    return any(
        a.step_n > 0.0 and b.step_n > 0.0 and abs(math.log(a.step_n / b.step_n)) < STEP
        for o in others
        for a, b in zip(e.sensors, o.sensors, strict=True)
    )


def _by_movement(log: Sequence[Evidence]) -> Iterator[tuple[Evidence, str, float]]:
    """Yield runs whose input goes over another range than that of all other runs of its movement, by a unit of force."""
    groups: dict[object, list[Evidence]] = {}
    for e in log:
        if e.tendon_like and e.trajectory is not None:
            groups.setdefault((e.system, e.trajectory, e.tendon), []).append(e)
            groups.setdefault((e.trajectory, e.tendon), []).append(e)
    told: set[str] = set()
    for runs in groups.values():
        for e, unit, size in _scaled(runs, log) if len(runs) > 2 else ():
            if e.run_id not in told:
                told.add(e.run_id)
                yield e, unit, size


def _scaled(runs: list[Evidence], log: Sequence[Evidence]) -> Iterator[tuple[Evidence, str, float]]:
    """Yield runs of one movement whose tensions are another unit of force than those of the rest."""
    spans = np.log([[max(r.span, 1e-300) for r in e.ranges] for e in runs])
    usual = np.median(spans, axis=0)
    near = np.abs(spans[:, 0] - usual[0]) < SAME
    # all others but a few move alike, so that the range of one is no choice of who pulled
    if np.count_nonzero(near) < max(2, 0.75 * (len(runs) - 1)):
        return
    rest = [e for e, n in zip(runs, near, strict=True) if n]
    for e, row in zip(runs, spans - usual, strict=True):
        for unit, size in FORCES.items():
            fits = abs(row[0] + math.log(size)) < SAME and abs(row[1] + math.log(size)) < RANGE
            if unit != "N" and fits and (_sensed(e, rest, math.log(size)) or _below_noise(e, log, size)):
                yield e, unit, float(row[0])


def _sensed(e: Evidence, rest: list[Evidence], size: float) -> bool:
    """Whether what the sensors show besides the movement is scaled as well: a smaller movement leaves it as it is."""
    told = []
    for i in (0, 1):
        for kind in ("step_n", "noise_n"):
            mine = getattr(e.sensors[i], kind)
            theirs = [v for o in rest if (v := getattr(o.sensors[i], kind)) > 0.0 and (kind == "step_n" or o.sensors[i].white)]
            if mine > 0.0 and theirs and (kind == "step_n" or e.sensors[i].white):
                told.append(abs(math.log(mine / float(np.median(theirs))) + size) < SENSED)
    return bool(told) and all(told)


def _below_noise(e: Evidence, log: Sequence[Evidence], size: float) -> bool:
    """Whether both channels show less than the least noise of these sensors, as the unit makes of it: no movement lowers that."""
    for i in (0, 1):
        floor = min((o.sensors[i].noise_n for o in log if o is not e and o.tendon_like and o.sensors[i].fine), default=0.0)
        if size < 1.0 or not QUIET * floor < e.sensors[i].noise_n * size or not e.sensors[i].noise_n < QUIET * floor:
            return False
    return True


def _usual(sizes: np.ndarray) -> int:
    """Return the run whose noise most others share; of two kinds as many, that with tensions a tendon has."""
    from scipy.spatial import cKDTree

    # all pairs at once would take the memory of the machine for a log of many runs
    tree = cKDTree(sizes[:, :2])
    near = tree.query_ball_point(sizes[:, :2], np.nextafter(NOISE, 0.0), p=np.inf, return_length=True)
    odd = np.abs(sizes[:, 2] - math.log(30.0))
    return int(np.lexsort((odd, -near))[0])


def _unit(row: np.ndarray) -> str | None:
    """Return the unit whose size explains all four ratios."""
    for unit, size in FORCES.items():
        away = row + math.log(size)
        if unit != "N" and bool(np.all(np.abs(away[:2]) < NOISE) and abs(away[2]) < RANGE and abs(away[3]) < BENDS):
            return unit
    return None

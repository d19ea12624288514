"""Shuffled labels: act and sstl (or two trajectories) disagree on which bend rubs more, and agree once re-ordered."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "labels", 55
Array = NDArray[np.float64]
Column = tuple[str, str | None, str | None]
# scatter of ln friction between columns as labelled, and what may remain of it in the best order
SCATTER, REMAINS = 0.05, 0.35
ERRORS = 4.0
CELL = 0.12


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose configuration label contradicts the friction they show."""
    known = [e for e in log if e.slopes.known and e.config_id is not None and e.slopes.friction > 0.05]
    yield from _cells(known)
    places: dict[object, list[Evidence]] = {}
    for e in known:
        places.setdefault(e.location, []).append(e)
    groups = [g for g in places.values() if len({e.config_id for e in g}) > 1]
    for group in groups or [known]:
        yield from _columns(group)


def _column(e: Evidence) -> Column:
    return e.system, e.trajectory, e.tendon


def _log(runs: list[Evidence]) -> float:
    return float(np.log(np.median([e.slopes.friction for e in runs])))


def _columns(group: list[Evidence]) -> Iterator[Remark]:
    """Compare how friction goes over the configurations in every column (system, trajectory, tendon)."""
    cells: dict[tuple[str, Column], list[Evidence]] = {}
    for e in group:
        cells.setdefault((str(e.config_id), _column(e)), []).append(e)
    columns = sorted({c for _, c in cells}, key=str)
    suspects: dict[Column, tuple[list[str], float]] = {}
    for column in columns:
        configs = sorted(k for k, c in cells if c == column)
        rest = [c for c in columns if c != column and all((k, c) in cells for k in configs)]
        if len(configs) < 2 or not rest:
            continue
        mine = np.array([_log(cells[k, column]) for k in configs])
        theirs = np.array([[_log(cells[k, c]) for k in configs] for c in rest])
        theirs -= theirs.mean(axis=1, keepdims=True)
        common = np.median(theirs, axis=0)
        error = max(e.slopes.friction_se / e.slopes.friction for k in configs for e in cells[k, column])
        found = _shuffled(mine - mine.mean(), common, error)
        if found is not None:
            suspects[column] = ([configs[i] for i in found[0]], found[1])
    if not suspects:
        return
    # with two columns either may be wrong; with more, the one that differs from all others
    hit = [e for c, (configs, _) in suspects.items() for k in configs for e in cells[k, c]]
    scatter = max(s for _, s in suspects.values())
    configs = sorted({str(e.config_id) for e in hit})
    ids = tuple(e.run_id for e in hit)
    which = " or ".join(" ".join(str(v) for v in c if v) for c in suspects)
    yield Remark(
        ids, RULE, "failure", 100.0 * scatter, "%",
        f"{names(ids)}: friction of configurations {', '.join(configs[:4])}{' ...' if len(configs) > 4 else ''} goes against "
        f"that of their other runs ({100 * scatter:.0f} % apart) and fits once the files are re-ordered; the files or "
        f"configuration labels of {which} are probably shuffled",
        "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
    )  # fmt: skip


def _shuffled(mine: Array, common: Array, error: float) -> tuple[list[int], float] | None:
    """Return which entries are out of order and by how much (ln), None where the order is right."""
    apart = float(np.sqrt(np.mean((mine - common) ** 2)))
    best = np.empty_like(mine)
    best[np.argsort(common)] = np.sort(mine)
    left = float(np.sqrt(np.mean((best - common) ** 2)))
    if apart < max(SCATTER, ERRORS * error) or left > REMAINS * apart:
        return None
    out = np.flatnonzero(np.abs(mine - common) > 0.5 * apart)
    return out.tolist(), float(np.max(np.abs(mine - common)))


def _cells(known: list[Evidence]) -> Iterator[Remark]:
    """Compare runs that claim the same configuration, system and trajectory."""
    cells: dict[object, list[Evidence]] = {}
    for e in known:
        cells.setdefault((e.config_id, e.location, *_column(e)), []).append(e)
    for runs in cells.values():
        if len(runs) < 2 or runs[0].trajectory is None:
            continue
        logs = np.log([e.slopes.friction for e in runs])
        apart = float(np.ptp(logs))
        error = max(e.slopes.friction_se / e.slopes.friction for e in runs)
        if apart < max(CELL, ERRORS * 1.5 * error):
            continue
        far = np.abs(logs - np.median(logs))
        ids = tuple(e.run_id for e, d in zip(runs, far, strict=True) if len(runs) < 3 or d > 0.5 * apart)
        yield Remark(
            ids, RULE, "remark", 100.0 * apart, "%",
            f"{names(ids)}: runs labelled configuration {runs[0].config_id} ({runs[0].system}, {runs[0].trajectory}) differ by "
            f"{100 * apart:.0f} % in friction; one of them probably belongs to another configuration",
            "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
        )  # fmt: skip

"""Shuffled labels: act and sstl (or two trajectories) disagree on which bend rubs more, and agree once re-ordered."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "labels", 55
Column = tuple[str, str | None, str | None]
# scatter of ln friction between columns as labelled, and what may remain of it once every column is sorted
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
    configs = sorted({k for k, _ in cells})
    columns = [c for c in sorted({c for _, c in cells}, key=str) if all((k, c) in cells for k in configs)]
    if len(configs) < 2 or len(columns) < 2:
        return
    table = np.array([[_log(cells[k, c]) for c in columns] for k in configs])
    table -= table.mean(axis=0)
    away = table - np.median(table, axis=1, keepdims=True)
    apart = float(np.sqrt(np.mean(away**2)))
    ordered = np.sort(table, axis=0)
    left = float(np.sqrt(np.mean((ordered - np.median(ordered, axis=1, keepdims=True)) ** 2)))
    error = max(e.slopes.friction_se / e.slopes.friction for c in columns for k in configs for e in cells[k, c])
    # one column of many weighs little in the mean
    share = np.sqrt(len(columns))
    if apart * share < max(SCATTER, ERRORS * error) or left > REMAINS * apart:
        return
    out = np.argwhere(np.abs(away) > 0.5 * float(np.abs(away).max()))
    ids = tuple(e.run_id for i, j in out for e in cells[configs[i], columns[j]])
    worst = 100.0 * float(np.abs(away).max())
    shown = ", ".join(configs[i] for i in sorted({int(i) for i, _ in out})[:4])
    which = " and ".join(sorted({columns[j][0] for _, j in out}))
    yield Remark(
        ids, RULE, "failure", worst, "%",
        f"{names(ids)}: friction of configurations {shown} goes against that of their other runs (up to {worst:.0f} % apart) "
        f"and fits once the files are re-ordered; the files or configuration labels of {which} runs are probably shuffled",
        "file_name = '(pattern that reads config_id from the name)', or a manifest with the right config_id",
    )  # fmt: skip


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

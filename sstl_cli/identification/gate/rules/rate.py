"""A sampling rate that differs between the runs of a log."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "rate", 18
APART = 1.25
LIKELY_S = 0.005
# factors between units of time
UNITS = {1e3: "ms", 1e6: "us", 60.0: "min"}


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the runs that are sampled otherwise than most."""
    runs = [e for e in log if e.samples > 16 and e.dt_s > 0.0]
    if len(runs) < 2:
        return
    steps = np.array([e.dt_s for e in runs])
    # the period that most runs share
    near = [int(np.sum(np.abs(np.log(steps / s)) < np.log(APART))) for s in steps]
    # of two rates as frequent it is that of a logger, some hundred samples a second
    usual = float(steps[np.lexsort((np.abs(np.log(steps / LIKELY_S)), -np.array(near)))[0]])
    groups: dict[tuple[str | None, float], list[Evidence]] = {}
    for e in runs:
        ratio = e.dt_s / usual
        if max(ratio, 1.0 / ratio) > APART:
            groups.setdefault((_unit(ratio), round(math.log(ratio), 1)), []).append(e)
    for (unit, _), hit in groups.items():
        ids = tuple(e.run_id for e in hit)
        step = hit[0].dt_s
        if unit is None and _own_recorders(runs):
            continue
        why = f"time is probably in {unit} in one of them" if unit else "they were probably recorded or exported differently"
        yield Remark(
            ids, RULE, "failure" if unit else "remark", 1.0 / step, "Hz",
            f"{names(ids)}: sampled at {1.0 / step:.4g} Hz, the other runs at {1.0 / usual:.4g} Hz; {why}",
            f'time_s = {{ column = ..., unit = "{unit or "s"}" }} (for this file)',
        )  # fmt: skip


def _own_recorders(runs: Sequence[Evidence]) -> bool:
    """Whether the two systems differ and the runs of each do not: then each has a recorder of its own."""
    steps = [np.log([e.dt_s for e in runs if e.system == s]) for s in {e.system for e in runs}]
    return len(steps) > 1 and all(float(np.ptp(s)) < np.log(APART) for s in steps)


def _unit(ratio: float) -> str | None:
    return next((name for size, name in UNITS.items() if abs(math.log(max(ratio, 1.0 / ratio) / size)) < 0.05), None)

"""Runs of one configuration that claim different settings of the lead screw: a configuration is one setting."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.core.units import UNITS
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "lead_mm", 56
# part of the way from one setting to the next by which readings of one setting do not differ: who tells them apart meets either far better
APART = 0.25
# part of the usual lead that a scale is read to, and that a setting is met again to where there is no other one
READ, MET = 0.01, 0.05
LENGTHS = {name: math.log(mm) for name, (kind, mm) in UNITS.items() if kind == "length" and name != "mm"}
# of the logarithm: how well a slip meets its factor
MEETS = 0.02
# by how much (logarithm of the likelihood) one of two settings must be likelier to be the right one
LIKELIER = 2.0
Cell = list[Evidence]


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose lead is not that of the other runs of their configuration."""
    cells: dict[object, Cell] = {}
    for e in log:
        if e.config_id is not None and e.lead_mm is not None and math.isfinite(e.lead_mm):
            cells.setdefault((e.config_id, e.location, e.tendon), []).append(e)
    least = _least(list(cells.values()))
    for cell in cells.values():
        kinds = _kinds(cell, least)
        if len(kinds) > 1:
            yield _told(kinds, [o for o in cells.values() if o is not cell], least)


def contradicting(log: Sequence[Evidence]) -> set[str]:
    """Return the names of runs whose lead is not to be believed."""
    return {name for r in look(log) for name in r.run_ids}


def _leads(runs: Cell) -> list[float]:
    return [float(e.lead_mm) for e in runs if e.lead_mm is not None]


def _usual(runs: Cell) -> float:
    return float(np.median(_leads(runs)))


def _least(cells: list[Cell]) -> float:
    """Return the difference (mm) from which on two leads are two settings, and not two readings of one."""
    if not cells:
        return math.inf
    size = float(np.median(np.abs([v for c in cells for v in _leads(c)])))
    leads, own = zip(*sorted((v, i) for i, c in enumerate(cells) for v in _leads(c)), strict=True)
    # from one configuration to the next: a wrong lead of one run makes no setting of its own; several places have settings in common
    gaps = np.diff(leads)[np.diff(own) != 0]
    gaps = gaps[gaps > READ * size]
    return max(READ * size, APART * float(np.min(gaps))) if len(gaps) else MET * size


def _kinds(cell: Cell, least: float) -> list[Cell]:
    """Return the runs of a configuration by their setting, those of most runs first."""
    runs = sorted(cell, key=lambda e: e.lead_mm or 0.0)
    ends = [0, *(np.flatnonzero(np.diff(_leads(runs)) > least) + 1).tolist(), len(runs)]
    return sorted((runs[a:b] for a, b in zip(ends[:-1], ends[1:], strict=True)), key=len, reverse=True)


def _told(kinds: list[Cell], rest: list[Cell], least: float) -> Remark:
    """Return what is said of a configuration of several settings beside the rest of the log."""
    beside = [c for c in rest if (c[0].location, c[0].tendon) == (kinds[0][0].location, kinds[0][0].tendon)]
    others = {str(c[0].config_id): _usual(c) for c in beside}
    right = _right(kinds, beside, least) or _likely(kinds, rest)
    which = kinds[0][0].config_id
    line = "config_id and lead_mm from file_name = '(pattern that reads both from the name)', or a manifest"
    if right is None:
        ids = tuple(e.run_id for kind in kinds for e in kind)
        leads = [_usual(kind) for kind in kinds]
        return Remark(
            ids, RULE, "remark", max(leads) - min(leads), "mm",
            f"{names(ids)}: configuration {which} has {len(kinds)} settings of the lead screw ({min(leads):.4g} to {max(leads):.4g} mm), where a "
            "configuration is one; lead_mm of some, or their config_id, is probably wrong",
            line,
        )  # fmt: skip
    hit = [e for kind in kinds if kind is not right for e in kind]
    ids, lead, usual = tuple(e.run_id for e in hit), _usual(hit), _usual(right)
    bend = next((k for k, v in others.items() if abs(v - lead) <= least), None)
    why, line = _why(lead, usual, bend, line)
    return Remark(
        ids, RULE, "remark", lead, "mm",
        f"{names(ids)}: lead_mm is {lead:.4g} where the other runs of configuration {which} have {usual:.4g}, and a configuration is one setting of "
        f"the lead screw; {why}",
        line,
    )  # fmt: skip


def _right(kinds: list[Cell], beside: list[Cell], least: float) -> Cell | None:
    """Return the runs whose lead is that of the configuration, None where none can be said to be."""
    if len(kinds[0]) > len(kinds[1]):
        return kinds[0] if 2 * len(kinds[0]) > sum(map(len, kinds)) else None
    if len(kinds) > 2:
        return None
    # of two as many: the lead of another configuration is no setting of this one, and friction follows the lead screw
    own = [k for k in kinds if not any(abs(_usual(c) - _usual(k)) <= least for c in beside)]
    if len(own) == 1:
        return own[0]
    first, second = (_ordered(_usual(k), [e for kind in kinds for e in kind], beside) for k in kinds)
    return None if first == second else kinds[0] if first > second else kinds[1]


def _likely(kinds: list[Cell], rest: list[Cell]) -> Cell | None:
    """Return which of two settings is by far the likelier one of a rig that has the other leads, None where neither is."""
    others, own = np.array([_usual(c) for c in rest]), np.array([_usual(k) for k in kinds])
    if len(kinds) != 2 or len(kinds[0]) > len(kinds[1]) or not len(others) or min(np.min(others), np.min(own)) <= 0.0:
        return None
    # settings of one rig are of one size: of few others their spread is hardly known
    spread = max(float(np.std(np.log(others))), math.log(2.0))
    nats = 0.5 * (np.log(own / np.median(others)) / spread) ** 2
    return kinds[int(np.argmin(nats))] if float(np.ptp(nats)) > LIKELIER else None


def _ordered(lead: float, cell: Cell, beside: list[Cell]) -> int:
    """Return how many pairs of configurations are in the order of their leads, more than against it (or against it, more than in it)."""
    leads = np.array([lead, *(_usual(c) for c in beside)])
    rubs = np.array([_rubs(c) for c in (cell, *beside)])
    # what is not known has no order
    signs = np.sign(np.subtract.outer(leads, leads) * np.subtract.outer(rubs, rubs))
    return abs(int(np.nansum(signs)))


def _rubs(cell: Cell) -> float:
    """Return n theta of one pass in a configuration, NaN where no run tells it."""
    known = [e.wrap / e.passes for e in cell if e.wrap > 0.0]
    return float(np.median(known)) if known else math.nan


def _why(lead: float, usual: float, bend: str | None, line: str) -> tuple[str, str]:
    """Return what probably happened to a lead, and the line that mends it."""
    mend = f"[constants] lead_mm = {usual:.4g} (for this file)"
    if bend is not None:
        return f"it is the lead of configuration {bend}, so that config_id (or lead_mm) is probably that of another run", line
    if lead * usual > 0.0:
        off = math.log(usual / lead)
        unit = min(LENGTHS, key=lambda name: abs(LENGTHS[name] - off))
        if abs(LENGTHS[unit] - off) < MEETS:
            return f"it is probably in {unit}, not mm", mend
        tens = off / math.log(10.0)
        if abs(tens - round(tens)) * math.log(10.0) < MEETS:
            return f"its decimal point has probably moved (a factor of {lead / usual:.3g})", mend
    return "it is probably wrong, or config_id is", f"{mend}, or {line}"

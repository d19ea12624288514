"""Rows of Theta brought together by configuration and tendon: the runs of each averaged, what cannot be used set aside."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from sstl_cli.core.sound import SLOPES, why_no_lines
from sstl_cli.core.tables import PARAMETERS


@dataclass(frozen=True)
class Averaged:
    """The lines of the runs of one system, and tendon, in one configuration: their means, biases in N, NaN where unknown."""

    runs: tuple[str, ...]
    location: str | None
    gamma_p: float
    beta_p: float
    gamma_r: float
    beta_r: float

    @property
    def slopes(self) -> tuple[float, float]:
        """Return the slopes of pull and release."""
        return self.gamma_p, self.gamma_r


@dataclass(frozen=True)
class Configuration:
    """One bending configuration: its sensing loop, and its actuation tendons by name ('' where it has none)."""

    name: str
    loop: Averaged | None
    tendons: dict[str, Averaged]


@dataclass(frozen=True)
class Unused:
    """A row that was set aside, and why."""

    run_id: str
    config: str
    why: str


def configurations(theta: pa.Table, alone: bool) -> tuple[list[Configuration], list[Unused]]:
    """Return the configurations of a Theta table in order of appearance, those with an actuation run first, and the rows set aside.

    A row is used if its status is ``ok`` and its slopes can be those of a loop; of a row that is not ok nobody knows which
    number is meant.

    Parameters
    ----------
    theta : pyarrow.Table
        Rows of ``sstl.theta``.
    alone : bool
        Whether a row without ``config_id`` is a configuration of its own, named like its run; else it is set aside.
    """
    loops: dict[str, list[Mapping[str, object]]] = {}
    acts: dict[str, dict[str, list[Mapping[str, object]]]] = {}
    unused = []
    for row in theta.to_pylist():
        run_id = str(row["run_id"])
        config = run_id if row["config_id"] is None else str(row["config_id"])
        why = "no config_id: nothing to pair it by" if row["config_id"] is None and not alone else _why_not(row)
        if why:
            unused.append(Unused(run_id, config, why))
        elif row["system"] == "sstl":
            loops.setdefault(config, []).append(row)
        else:
            acts.setdefault(config, {}).setdefault(str(row.get("tendon") or ""), []).append(row)
    found = []
    for name in dict.fromkeys([*acts, *loops]):
        loop = _averaged(loops[name]) if name in loops else None
        found.append(Configuration(name, loop, {tendon: _averaged(rows) for tendon, rows in acts.get(name, {}).items()}))
    return found, unused


def _why_not(row: Mapping[str, object]) -> str:
    """Return why the lines of a row cannot be used, else ''."""
    if row["system"] not in ("act", "sstl"):
        return f"system '{row['system']}' is neither act nor sstl"
    if row["status"] != "ok":
        return str(row["status"])
    for name in SLOPES:
        value = row[name]
        if not isinstance(value, float):
            return f"{name} is null"
        if math.isnan(value):
            return f"{name} is not a number"
    return next((f"{name} {why}" for name, why in why_no_lines(row).items() if name in PARAMETERS), "")


def _averaged(rows: list[Mapping[str, object]]) -> Averaged:
    location = next((str(r["location"]) for r in rows if r["location"] is not None), None)
    return Averaged(tuple(str(r["run_id"]) for r in rows), location, **{name: _mean(rows, name) for name in PARAMETERS})


def _mean(rows: list[Mapping[str, object]], name: str) -> float:
    known = [v for v in (r[name] for r in rows) if isinstance(v, float) and math.isfinite(v)]
    return float(np.mean(known)) if known else math.nan

"""Pair the sensing loop with the actuation tendons of the same bending configuration."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.sound import why_no_lines
from sstl_cli.core.tables import PARAMETERS

Array = NDArray[np.float64]
MIN_CONFIGS = 8


@dataclass(frozen=True)
class Pairs:
    """Paired slopes, one row a configuration and tendon, ordered by configuration and tendon.

    Attributes
    ----------
    config_id, location, tendon : tuple of str
        Labels; location and tendon are empty where the table has none.
    sstl, act : array, shape (n, 2)
        Slopes Gamma_p, Gamma_r of both systems, dimensionless.
    beta_act : array, shape (n, 2)
        Biases beta_p, beta_r of the actuation tendon in N; NaN where unknown.
    aside : dict
        What could not be paired, and why.
    rows : int
        Rows of the tables, those set aside included.
    """

    config_id: tuple[str, ...]
    location: tuple[str, ...]
    tendon: tuple[str, ...]
    sstl: Array
    act: Array
    beta_act: Array
    aside: dict[str, str]
    rows: int

    def __len__(self) -> int:
        return len(self.config_id)

    @property
    def configs(self) -> tuple[str, ...]:
        """Configurations in order, each once."""
        return tuple(dict.fromkeys(self.config_id))

    @property
    def tendons(self) -> tuple[str, ...]:
        """Names of the actuation tendons, sorted; empty where the tables name fewer than two."""
        names = tuple(sorted(set(self.tendon)))
        return names if len(names) > 1 else ()

    def location_of(self) -> dict[str, str]:
        """Return the location of every configuration."""
        return dict(zip(self.config_id, self.location, strict=True))

    def take(self, index: Sequence[int] | NDArray[np.int64]) -> Pairs:
        """Return the pairs at the given positions."""
        at = [int(i) for i in index]
        labels = ([values[i] for i in at] for values in (self.config_id, self.location, self.tendon))
        config_id, location, tendon = (tuple(v) for v in labels)
        return Pairs(config_id, location, tendon, self.sstl[at], self.act[at], self.beta_act[at], self.aside, self.rows)

    def sha256(self) -> str:
        """Return the SHA-256 of labels and values: equal data in another file or order has the same."""
        digest = hashlib.sha256("\n".join("\t".join(r) for r in zip(self.config_id, self.tendon, strict=True)).encode())
        for values in (self.sstl, self.act):
            digest.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
        return digest.hexdigest()


def pairs_of(theta: pa.Table) -> Pairs:
    """Return the pairs of a Theta table; rows are paired by configuration, several runs of one are averaged.

    A column ``tendon`` splits the actuation side of a configuration; all its tendons share the sensing loop.

    Parameters
    ----------
    theta : pyarrow.Table
        Rows of ``sstl.theta``; a row without finite positive slopes or without configuration is set aside.
    """
    aside: dict[str, str] = {}
    loops: dict[str, list[dict[str, object]]] = {}
    acts: dict[str, dict[str, list[dict[str, object]]]] = {}
    for row in theta.to_pylist():
        why = _unusable(row)
        if why:
            aside[str(row["run_id"])] = why
        elif row["system"] == "sstl":
            loops.setdefault(str(row["config_id"]), []).append(row)
        else:
            acts.setdefault(str(row["config_id"]), {}).setdefault(str(row.get("tendon") or ""), []).append(row)
    for config, found in ((c, r) for c, r in loops.items() if c not in acts):
        aside.update({str(r["run_id"]): f"configuration {config} has no actuation run" for r in found})
    for config, tendons in ((c, t) for c, t in acts.items() if c not in loops):
        alone = [r for rows in tendons.values() for r in rows]
        aside.update({str(r["run_id"]): f"configuration {config} has no sensing-loop run" for r in alone})
    labels: list[tuple[str, str, str]] = []
    values: list[list[float]] = []
    for config in sorted(set(loops) & set(acts)):
        sstl = [_mean(loops[config], n) for n in ("gamma_p", "gamma_r")]
        for tendon, rows in sorted(acts[config].items()):
            place = next((str(r["location"]) for r in [*rows, *loops[config]] if r["location"] is not None), "")
            labels.append((config, place, tendon))
            values.append(sstl + [_mean(rows, n) for n in ("gamma_p", "gamma_r", "beta_p", "beta_r")])
    table = np.array(values, dtype=np.float64).reshape(-1, 6)
    configs, places, names = (tuple(label[i] for label in labels) for i in range(3))
    return Pairs(configs, places, names, table[:, :2], table[:, 2:4], table[:, 4:], aside, theta.num_rows)


def require_enough(pairs: Pairs, where: str = "") -> None:
    """Raise SstlError (E502) unless there are enough paired configurations to train and hold some out."""
    found = len(pairs.configs)
    if found >= MIN_CONFIGS:
        return
    reasons = "; ".join(f"{k}: {v}" for k, v in list(pairs.aside.items())[:3])
    raise SstlError(
        f"has {found} paired configurations, training needs {MIN_CONFIGS}" + (f" (set aside: {reasons})" if reasons else ""),
        where=where,
        fix="record act and sstl runs with the same config_id",
        code="E502",
    )


def _unusable(row: dict[str, object]) -> str:
    if row["config_id"] is None:
        return "no config_id: nothing to pair it by"
    if row["system"] not in ("act", "sstl"):
        return f"system '{row['system']}' is neither act nor sstl"
    for name in ("gamma_p", "gamma_r"):
        value = row[name]
        if not isinstance(value, float):
            return f"{name} is null" + (f" ({row['status']})" if row["status"] != "ok" else "")
        if not 0 < value < np.inf:
            return f"{name} is not a positive number"
    return next((f"{name} {why}" for name, why in why_no_lines(row).items() if name in PARAMETERS), "")


def _mean(rows: list[dict[str, object]], name: str) -> float:
    found = [v for v in (r[name] for r in rows) if isinstance(v, float)]
    known = [v for v in found if np.isfinite(v)]
    return float(np.mean(known)) if known else float("nan")

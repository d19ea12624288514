"""Pair the sensing loop with the actuation tendons of the same bending configuration."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.mapping.configurations import configurations

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
        Rows of ``sstl.theta``; a row that is not ok, has no usable slopes or no configuration is set aside.
    """
    found, unused = configurations(theta, alone=False)
    aside = {u.run_id: u.why for u in unused}

    def usable(config: str) -> str:
        return " that can be used" if any(u.config == config for u in unused) else ""

    labels: list[tuple[str, str, str]] = []
    values: list[list[float]] = []
    for one in sorted(found, key=lambda c: c.name):
        if one.loop is None:
            why = f"configuration {one.name} has no sensing-loop run{usable(one.name)}"
            aside |= {run: why for t in one.tendons.values() for run in t.runs}
            continue
        if not one.tendons:
            aside |= dict.fromkeys(one.loop.runs, f"configuration {one.name} has no actuation run{usable(one.name)}")
        for tendon, act in sorted(one.tendons.items()):
            labels.append((one.name, act.location or one.loop.location or "", tendon))
            values.append([*one.loop.slopes, *act.slopes, act.beta_p, act.beta_r])
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

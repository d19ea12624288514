"""The catalogue of effects from Python."""

from __future__ import annotations

import pandas as pd

from sstl_cli.physics.effects import catalogue


def effects() -> pd.DataFrame:
    """Return one row a parameter of every effect that a simulator may leave out, as ``sstl effects`` lists and shows them.

    Examples
    --------
    >>> effects().query("id == 'slack'")[["name", "unit", "high"]].values.tolist()
    [['gap_mm', 'mm', 5.0]]
    """
    columns = ["id", "title", "stage", "equation", "excitation", "name", "unit", "neutral", "low", "high", "meaning"]
    rows = [
        (e.id, e.title, e.stage, e.equation, e.excitation, p.name, p.unit, p.neutral, p.low, p.high, p.meaning)
        for e in catalogue().values()
        for p in e.parameters
    ]
    return pd.DataFrame(rows, columns=columns)

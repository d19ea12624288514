"""Tensions far from those of the catalogue's ranges, brought there for the fit and back for the answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import HIGH_N, LOW_N, TARGET_N, UNSEEN_SHARE
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

POWERS = {"N": 1, "N s/mm": 1, "1/N": -1, "mm/N": -1, "1/kN": -1, "s/N": -1, "s/N^2": -2}


def unit_of(runs: Sequence[Run]) -> float:
    """Return how many N of the recording are one N of the fit: 1 within 3-60 N, else a round number."""
    # above the top are spikes
    tops = [np.nanquantile(np.abs(r.tension_in_n), 1.0 - UNSEEN_SHARE) for r in runs if np.isfinite(r.tension_in_n).any()]
    top = float(max(tops, default=TARGET_N))
    if LOW_N <= top <= HIGH_N or top == 0.0:
        return 1.0
    return float(f"{top / TARGET_N:.2g}")


def scaled(runs: Sequence[Run], unit_n: float) -> list[Run]:
    """Return runs with their tensions in units of ``unit_n`` (N)."""
    if unit_n == 1.0:
        return list(runs)
    return [
        replace(
            r,
            tension_in_n=r.tension_in_n / unit_n,
            tension_out_n=r.tension_out_n / unit_n,
            tension_ref_n=None if r.tension_ref_n is None else r.tension_ref_n / unit_n,
            extra={k: v / unit_n if k.endswith("_n") else v for k, v in r.extra.items()},
        )
        for r in runs
    ]


def parameter(value: float, unit: str, unit_n: float) -> float:
    """Return a parameter of the scaled fit in the units of the recording."""
    return value * unit_n ** POWERS.get(unit, 0)


def effects(simulator: Scenario, unit_n: float) -> dict[str, dict[str, float]]:
    """Return the effects of a simulator, given in the units of the recording, in those of the scaled fit."""
    units = {e: {p.name: p.unit for p in get(e).parameters} for e in simulator.effects}
    return {e: {k: x / unit_n ** POWERS.get(units[e][k], 0) for k, x in v.items()} for e, v in simulator.effects.items()}


def mechanics(simulator: Scenario, unit_n: float) -> Mechanics:
    """Return the mechanics of a simulator, given in the units of the recording, in those of the scaled fit."""
    own = simulator.rig.mechanics()
    return replace(own, ea_n=own.ea_n / unit_n, load_n_per_mm=own.load_n_per_mm / unit_n)


def in_proportion(unit_n: float) -> Scenario:
    """Return the simulator of a rig that nothing is known of: the usual one, as much stiffer as its tensions are larger."""
    usual = Scenario()
    return usual.with_rig(ea_n=usual.rig.ea_n * unit_n, load_n_per_mm=usual.rig.load_n_per_mm * unit_n)


def restore(document: Any, unit_n: float) -> Any:
    """Return a diagnosis with every tension in N again: keys that end in ``_n``, and parameters by their unit; not within a scenario."""
    if unit_n == 1.0:
        return document
    if isinstance(document, list):
        return [restore(item, unit_n) for item in document]
    if not isinstance(document, dict):
        return document
    power = unit_n ** POWERS.get(document["unit"], 0) if isinstance(document.get("unit"), str) else 1.0
    if {"name", "unit", "estimate", "ci95"} <= document.keys():
        return {**document, **_times(document, power)}
    found = {}
    for key, item in document.items():
        number = isinstance(item, int | float | np.ndarray) and not isinstance(item, bool)
        if key.endswith("_n") and isinstance(item, dict) and {"estimate", "ci95"} <= item.keys():
            found[key] = {**item, **_times(item, unit_n)}
        elif key == "scenario":
            # it stays as it is fitted: ``tension_factor`` beside it says what one N of it is
            found[key] = item
        elif key == "size" and "parameter" in document:
            found[key] = item * power
        else:
            found[key] = item * unit_n if key.endswith("_n") and number else restore(item, unit_n)
    return found


def _times(estimated: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """Return an estimate and its interval, where there is one, times a factor."""
    interval = estimated["ci95"]
    return {
        "estimate": estimated["estimate"] * factor,
        "ci95": None if interval is None else [None if v is None else v * factor for v in interval],
    }

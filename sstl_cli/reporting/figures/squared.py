"""SSTL slope against the squared actuation slope: equal where two passes are simply one pass twice."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("theta",)


@dataclass(frozen=True)
class Points:
    """Squared act slope (x) and sstl slope (y) of every configuration with both."""

    x: list[float] = field(default_factory=list)
    y: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Passes:
    """The points of pull (``gamma_p``) and release (``gamma_r``) by location."""

    locations: dict[str, dict[str, Points]]


def data(rows: list[ThetaRow]) -> Passes:
    """Return the slopes of the configurations with both systems; runs of one configuration and system are averaged."""
    groups: dict[tuple[str, str], dict[str, list[ThetaRow]]] = {}
    for row in rows:
        if row.config_id is not None:
            groups.setdefault((row.location or "–", row.config_id), {}).setdefault(row.system, []).append(row)
    found: dict[str, dict[str, Points]] = {}
    for (location, _), systems in sorted(groups.items()):
        for p in ("gamma_p", "gamma_r"):
            act, sstl = (_mean([number(getattr(r, p)) for r in systems.get(s, [])]) for s in ("act", "sstl"))
            if act == act and sstl == sstl:
                points = found.setdefault(location, {}).setdefault(p, Points())
                points.x.append(act**2)
                points.y.append(sstl)
    return Passes(found)


def default(inputs: Inputs, run: str | None) -> Passes | None:
    """Return the data of all configurations, if any has both systems."""
    found = data(inputs.theta) if run is None else None
    return found if found is not None and found.locations else None


def figure(data: Passes) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, 3.5), (1, 2)


def draw(axes: Any, data: Passes) -> None:
    """Draw pull and release beside each other with the line of equality."""
    names = sorted(data.locations)
    for panel, p, title in zip(axes.flat, ("gamma_p", "gamma_r"), ("pull", "release"), strict=True):
        values: list[float] = []
        for location in names:
            points = data.locations[location].get(p, Points())
            values += points.x + points.y
            panel.plot(points.x, points.y, "o", markersize=4.5, color=palette.of(location, palette.LOCATIONS, names), label=label(location))
        if values:
            low, high = min(values), max(values)
            pad = 0.05 * (high - low or 0.1)
            panel.plot([low - pad, high + pad], [low - pad, high + pad], color=palette.INK, linewidth=1, linestyle="--", label="equal")
        panel.set_xlabel(f"(Γ {title} of act)² / 1")
        panel.set_ylabel(f"Γ {title} of sstl / 1")
        panel.legend(loc="best")


def alt(data: Passes) -> str:
    """Describe the picture in words, with the mean ratio of both sides."""
    text = []
    for p, title in (("gamma_p", "pull"), ("gamma_r", "release")):
        ratio = [y / x for g in data.locations.values() for x, y in zip(g.get(p, Points()).x, g.get(p, Points()).y, strict=True)]
        if ratio:
            text.append(f"{title}: {len(ratio)} configurations, mean ratio {np.mean(ratio):.3f}")
    return "SSTL slope against squared actuation slope; " + "; ".join(text) + "."


def _mean(values: list[float]) -> float:
    good = [v for v in values if v == v]
    return sum(good) / len(good) if good else float("nan")

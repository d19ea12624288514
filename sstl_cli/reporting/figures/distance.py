"""Isolation over the squared distance to base and nearest rival, beside the curve of an ideal observer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.core.observer import ideal
from sstl_cli.reporting import palette
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.scored import Scored

NEEDS = ("blind",)
RATES = {"isolation": ("named exactly", palette.BLUE, "o"), "in_group": ("in the ambiguity set", palette.ORANGE, "s")}
# odds of 49 to 1 in 95 of 100 repetitions, as the diagnosis has it, which lies above this layer; a test holds the two together
DECIDABLE = 24.0
# below this the axis is linear: distances may be 0
LINEAR = 1.0


@dataclass(frozen=True)
class Points:
    """One rate in strata of the distance: median D^2 of the stratum, share, its interval and the cases."""

    d2: list[float]
    share: list[float]
    low: list[float]
    high: list[float]
    n: list[float]


@dataclass(frozen=True)
class Distances:
    """Points by rate, ascending in D^2."""

    rates: dict[str, Points]


def data(document: Scored) -> Distances:
    """Return the strata that hold single effects."""
    rows = sorted((r for r in document.by_d2 if r.d2_median == r.d2_median), key=lambda r: r.d2_median)
    found = {}
    for name in RATES:
        seen = [(max(r.d2_median, 0.0), getattr(r, name)) for r in rows if getattr(r, name).share == getattr(r, name).share]
        if seen:
            found[name] = Points([d for d, _ in seen], *([getattr(rate, k) for _, rate in seen] for k in ("share", "low", "high", "n")))
    return Distances(found)


def default(inputs: Inputs, run: str | None) -> Distances | None:
    """Return the data of the first blind result; None where its distances are not known."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else None
    return found if found is not None and found.rates else None


def figure(data: Distances) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (5.6, 3.9), (1, 1)


def draw(axes: Any, data: Distances) -> None:
    """Draw the rates with their intervals and cases, and what an ideal observer would name."""
    most = max([100.0, *(d for p in data.rates.values() for d in p.d2)])
    grid = np.concatenate((np.linspace(0.0, LINEAR, 20), np.geomspace(LINEAR, 2.0 * most, 300)))
    axes.plot(grid, [ideal(d) for d in grid.tolist()], color=palette.INK, linestyle="--", linewidth=1.2, label="ideal observer")
    axes.axvline(DECIDABLE, color=palette.GREY, linewidth=0.8, linestyle=":", label=f"decidable from {DECIDABLE:g}")
    for place, (name, points) in enumerate(data.rates.items()):
        said, colour, marker = RATES[name]
        below = [max(0.0, s - low) for s, low in zip(points.share, points.low, strict=True)]
        above = [max(0.0, high - s) for s, high in zip(points.share, points.high, strict=True)]
        # a little apart, so that intervals do not hide one another
        x = [d * 1.12**place for d in points.d2]
        axes.errorbar(x, points.share, [below, above], color=colour, marker=marker, linestyle="-", capsize=2.5, linewidth=1.0, label=said)
    for d, n in zip(*_cases(data), strict=True):
        axes.annotate(f"{n:.0f}", (d, -0.075), ha="center", fontsize=8, color=palette.INK)
    axes.set_xscale("symlog", linthresh=LINEAR)
    axes.set_xlim(-0.15, 2.0 * most)
    # names of its own: those of matplotlib are formulas
    ticks = [0.0, *(10.0**k for k in range(int(np.log10(2.0 * most)) + 1))]
    axes.set_xticks(ticks, [f"{t:.0f}" for t in ticks])
    axes.set_ylim(-0.11, 1.05)
    axes.set_xlabel("D^2 to base and nearest rival / 1 (below: cases)")
    axes.set_ylabel("share of single effects / 1")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=2)


def _cases(data: Distances) -> tuple[list[float], list[float]]:
    points = data.rates.get("isolation") or next(iter(data.rates.values()))
    return points.d2, points.n


def alt(data: Distances) -> str:
    """Describe the points in words."""
    parts = [
        f"{RATES[name][0]} "
        + ", ".join(f"{s:.2f} of {n:.0f} at {d:.3g} (ideal {ideal(d):.2f})" for d, s, n in zip(p.d2, p.share, p.n, strict=True))
        for name, p in data.rates.items()
    ]
    return "Share of single effects over D^2: " + "; ".join(parts) + "."

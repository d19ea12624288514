"""Marks that several figures share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label


def points(panel: Any, x: Sequence[float], y: Sequence[float], name: str, names: list[str]) -> None:
    """Draw what belongs to one location or variant, of all that are drawn, as points."""
    panel.plot(x, y, "o", markersize=4, label=label(name), color=palette.of(name, palette.LOCATIONS, names))


def with_errors(
    panel: Any, x: Sequence[float], y: Sequence[float], se: Sequence[float], place: tuple[str, str], locations: list[str]
) -> None:
    """Draw values of one system and location (``place``) over lead with their standard errors; those that are not known have none."""
    system, location = place
    colour = palette.of(location, palette.LOCATIONS, locations)
    panel.errorbar(
        x,
        y,
        yerr=[0.0 if e != e else e for e in se],
        fmt=palette.SYSTEM_MARKERS.get(system, "^"),
        color=colour,
        markersize=4.5,
        markerfacecolor=colour if system == "act" else palette.PAPER,
        elinewidth=1,
        capsize=2,
        linestyle="none",
        label=label(f"{system} {location}"),
    )

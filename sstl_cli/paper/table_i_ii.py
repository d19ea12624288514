"""Tables I and II from recordings: simulate the configurations, segment every run, take the statistics."""

from __future__ import annotations

from dataclasses import dataclass

import pyarrow as pa

from sstl_cli.identification import SegmentOptions
from sstl_cli.paper.statistics import Key, slope_entries
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps import segment, simulate


@dataclass(frozen=True)
class Slopes:
    """Identified Theta of the 40 configurations, the entries they give, and two segmented runs to show."""

    theta: pa.Table
    entries: dict[Key, float]
    shown: tuple[segment.Segmented, ...]


def identify(scenario: Scenario, seed: int, show: str = "") -> tuple[pa.Table, tuple[segment.Segmented, ...]]:
    """Return the Theta table of a scenario's recordings, and the segmented runs of configuration ``show``."""
    rows, shown = [], []
    for one in segment.run(simulate.run(scenario, {}, seed), SegmentOptions(seed=seed)):
        rows.append(one.row())
        if show and one.run.config_id == show:
            shown.append(one)
    return segment.theta_table(rows), tuple(shown)


def run(seed: int) -> Slopes:
    """Return Tables I and II of the 40 simulated CP configurations."""
    theta, shown = identify(load("paper-cp40"), seed, show="CP-0500")
    return Slopes(theta, slope_entries(theta), shown)

"""The diagnosis beside simple baselines on the same cases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.figures.strength import SCORES
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.scored import Scored

NEEDS = ("blind",)


@dataclass(frozen=True)
class Bars:
    """Names in the document's order, and by score the share of each of them."""

    names: list[str]
    scores: dict[str, list[float]]


def data(document: Scored) -> Bars:
    """Return the share of each score that the document has."""
    found = {s: [rule.of(s).share for rule in document.baselines] for s in SCORES}
    return Bars([rule.name for rule in document.baselines], {s: v for s, v in found.items() if any(x == x for x in v)})


def default(inputs: Inputs, run: str | None) -> Bars | None:
    """Return the data of the first blind result."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else None
    return found if found is not None and found.scores else None


def figure(data: Bars) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, max(2.6, 1.6 + 0.5 * len(data.names))), (1, 1)


def draw(axes: Any, data: Bars) -> None:
    """Draw one group of bars a baseline."""
    height = 0.8 / len(data.scores)
    for k, (score, values) in enumerate(data.scores.items()):
        name, colour, _, _ = SCORES[score]
        places = np.arange(len(values)) + (k - (len(data.scores) - 1) / 2) * height
        axes.barh(places, values, height=0.9 * height, color=colour, label=name, zorder=2)
    axes.set_yticks(range(len(data.names)), [label(n) for n in data.names])
    axes.invert_yaxis()
    axes.set_xlim(0, 1.02)
    axes.set_xlabel("share of cases / 1")
    axes.grid(False, axis="y")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.22), ncols=2)


def alt(data: Bars) -> str:
    """Describe the bars in words."""
    parts = [f"{n}: " + ", ".join(f"{SCORES[s][0]} {v[i]:.2f}" for s, v in data.scores.items()) for i, n in enumerate(data.names)]
    return "Scores beside the baselines; " + "; ".join(parts) + "."

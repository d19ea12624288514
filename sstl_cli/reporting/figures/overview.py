"""All loops at a glance: one small picture a run, the same scale for all."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.figures.loop import by_phase
from sstl_cli.reporting.inputs import Array, Inputs, RunView, Segments
from sstl_cli.reporting.reduce import keep

NEEDS = ("log",)
COLUMNS, MOST, STRETCHES = 6, 120, 50


@dataclass(frozen=True)
class Small:
    """One thinned loop."""

    run: str
    curves: dict[str, tuple[Array, Array]]


@dataclass(frozen=True)
class Loops:
    """Loops of some ``of`` the runs, and the range of input and output that they share (N)."""

    loops: list[Small]
    span: tuple[float, float, float, float]
    of: int


def data(runs: list[RunView], phases: dict[str, Segments]) -> Loops:
    """Return thinned loops of at most MOST runs, evenly chosen."""
    chosen = runs if len(runs) <= MOST else [runs[i] for i in np.linspace(0, len(runs) - 1, MOST).astype(int)]
    loops = []
    for run in chosen:
        index = keep([run.tension_in_n, run.tension_out_n], STRETCHES)
        x, y = run.tension_in_n[index], run.tension_out_n[index]
        known = phases.get(run.run_id)
        curves = {"all": (x, y)} if known is None else by_phase(x, y, known.at(run.time_s[index]))
        loops.append(Small(run.run_id, curves))
    span = (*_span([r.input_range_n for r in chosen]), *_span([r.output_range_n for r in chosen]))
    return Loops(loops, span, len(runs))


def default(inputs: Inputs, run: str | None) -> Loops | None:
    """Return the data of all runs."""
    return data(inputs.log, inputs.phases) if inputs.log and run is None else None


def figure(data: Loops) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    rows = math.ceil(len(data.loops) / COLUMNS)
    return (9.6, 0.6 + 1.5 * rows), (rows, COLUMNS)


def draw(axes: Any, data: Loops) -> None:
    """Draw one small loop a pair of axes; only the outer ones carry numbers."""
    x0, x1, y0, y1 = data.span
    flat = list(axes.flat)
    for place, panel in enumerate(flat):
        if place >= len(data.loops):
            panel.set_visible(False)
            continue
        loop = data.loops[place]
        for name, (x, y) in loop.curves.items():
            panel.plot(x, y, color=palette.PHASES.get(name, palette.BLUE if name == "all" else palette.GREY), linewidth=1.1)
        panel.set_title(label(loop.run, 20), fontsize=8, loc="left")
        panel.set_xlim(x0, x1)
        panel.set_ylim(y0, y1)
        panel.locator_params(nbins=3)
        panel.tick_params(labelsize=7.5, labelleft=place % COLUMNS == 0, labelbottom=place + COLUMNS >= len(data.loops))
    flat[0].figure.supxlabel("input tension / N", fontsize=9.5)
    flat[0].figure.supylabel("output tension / N", fontsize=9.5)


def alt(data: Loops) -> str:
    """Describe the picture in words."""
    x0, x1, y0, y1 = data.span
    return (
        f"Hysteresis loops of {len(data.loops)} of {data.of} runs at one scale, input {x0:.3g} to {x1:.3g} N, "
        f"output {y0:.3g} to {y1:.3g} N."
    )


def _span(ranges: list[tuple[float, float]]) -> tuple[float, float]:
    """Return the range that holds all others; 0 to 1 where nothing was measured, so that axes can be drawn."""
    good = [v for pair in ranges for v in pair if v == v]
    return (min(good), max(good)) if good else (0.0, 1.0)

"""The hysteresis loop: output against input tension, coloured by phase, with the fitted lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import PHASE_CODES, Array, Inputs, RunView, Segments

NEEDS = ("log",)


@dataclass(frozen=True)
class Line:
    """A fitted line between the ends of the input, in N."""

    x: tuple[float, float]
    y: tuple[float, float]
    slope: float
    bias: float


@dataclass(frozen=True)
class Drawn:
    """A loop as one polyline a phase (NaN between stretches), and its fitted lines by side."""

    run: str
    system: str
    curves: dict[str, tuple[Array, Array]]
    lines: dict[str, Line]
    output_range_n: tuple[float, float]


def data(run: RunView, phases: Segments | None = None, fit: ThetaRow | None = None) -> Drawn:
    """Return the loop and the ends of the fitted lines.

    Parameters
    ----------
    run : RunView
        Tensions in N.
    phases : Segments, optional
        Phases of this run; without them the loop is one polyline named ``all``.
    fit : ThetaRow, optional
        Slopes and biases (N); null where a line was not fitted.
    """
    x, y = run.tension_in_n, run.tension_out_n
    curves = {"all": (x, y)} if phases is None else by_phase(x, y, phases.at(run.time_s))
    sides = {} if fit is None else {"pull": (fit.gamma_p, fit.beta_p), "release": (fit.gamma_r, fit.beta_r)}
    lines = {}
    low, high = run.input_range_n
    for name, (slope, bias) in sides.items():
        if slope is not None and bias is not None and not np.isnan([slope, bias, low]).any():
            lines[name] = Line((low, high), (slope * low + bias, slope * high + bias), slope, bias)
    return Drawn(run.run_id, run.system, curves, lines, run.output_range_n)


def by_phase(x: Array, y: Array, code: np.ndarray) -> dict[str, tuple[Array, Array]]:
    """Return one polyline a phase; a line between two samples has the phase of its end."""
    curves = {}
    gap = np.array([np.nan])
    for i, name in [*enumerate(PHASE_CODES), (-1, "unknown")]:
        ends = np.flatnonzero(code[1:] == i) + 1
        if len(ends) == 0:
            continue
        pieces = np.split(ends, np.flatnonzero(np.diff(ends) > 1) + 1)
        spans = [slice(p[0] - 1, p[-1] + 1) for p in pieces]
        first, second = (np.concatenate([part for s in spans for part in (v[s], gap)])[:-1] for v in (x, y))
        curves[name] = (first, second)
    return curves


def default(inputs: Inputs, run: str | None) -> Drawn | None:
    """Return the data of the named run, or of the first."""
    found = next((r for r in inputs.log if run is None or r.run_id == run), None)
    return data(found, inputs.phases.get(found.run_id), fit_of(inputs, found)) if found else None


def fit_of(inputs: Inputs, run: RunView) -> ThetaRow | None:
    """Return the Theta row of a run: by run_id, else by configuration and system if there is just one."""
    rows = [t for t in inputs.theta if t.run_id == run.run_id]
    if not rows and run.config_id is not None:
        rows = [t for t in inputs.theta if (t.config_id, t.system) == (run.config_id, run.system)]
    return rows[0] if len(rows) == 1 else None


def figure(data: Drawn) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: Drawn) -> None:
    """Draw one loop on one pair of axes."""
    for name, (x, y) in data.curves.items():
        colour = palette.PHASES.get(name, palette.BLUE if name == "all" else palette.GREY)
        text = f"{name} ({palette.PHASE_NAMES[name]})" if name in palette.PHASE_NAMES else None
        axes.plot(x, y, color=colour, label=text, linewidth=1.5)
    for name, line in data.lines.items():
        sign = "+" if line.bias >= 0 else "−"
        axes.plot(
            line.x,
            line.y,
            color=palette.INK,
            linestyle="--" if name == "pull" else ":",
            linewidth=1.2,
            label=f"{name} fit: {line.slope:.3f} in {sign} {abs(line.bias):.2f} N",
        )
    # a fitted line runs far beyond the loop at its unused end: the loop decides the scale
    bottom, top = data.output_range_n
    if top > bottom:
        axes.set_ylim(bottom - 0.06 * (top - bottom), top + 0.06 * (top - bottom))
    axes.set_xlabel("input tension / N")
    axes.set_ylabel("output tension / N")
    axes.set_title(label(f"{data.run} ({data.system})", 52), loc="left")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=2, columnspacing=1.2, handlelength=1.6, fontsize=8)


def alt(data: Drawn) -> str:
    """Describe the loop in words."""
    text = f"Hysteresis loop of run {data.run} ({data.system}), output against input tension"
    phases = [n for n in data.curves if n in palette.PHASES]
    text += f", coloured by phase {', '.join(phases)}" if phases else ""
    for name, line in data.lines.items():
        text += f"; fitted {name} line with slope {line.slope:.3f} and bias {line.bias:.2f} N"
    return text + "."

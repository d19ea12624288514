"""The hysteresis loop: output against input tension, coloured by phase, with the fitted lines."""

from __future__ import annotations

from typing import Any

import numpy as np

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import PHASE_CODES, Array, Inputs, RunView, Segments

NEEDS = ("log",)


def data(run: RunView, phases: Segments | None = None, fit: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return the loop as one polyline a phase (NaN between stretches) and the ends of the fitted lines.

    Parameters
    ----------
    run : RunView
        Tensions in N.
    phases : Segments, optional
        Phases of this run; without them the loop is one polyline named ``all``.
    fit : dict, optional
        gamma_p, beta_p (N), gamma_r, beta_r (N); null where a line was not fitted.
    """
    x, y = run.tension_in_n, run.tension_out_n
    curves = {"all": (x, y)} if phases is None else by_phase(x, y, phases.at(run.time_s))
    lines = {}
    low, high = run.input_range_n
    for side, name in (("p", "pull"), ("r", "release")):
        slope, bias = ((fit or {}).get(k + side) for k in ("gamma_", "beta_"))
        if slope is not None and bias is not None and not np.isnan([slope, bias, low]).any():
            lines[name] = {"x": [low, high], "y": [slope * low + bias, slope * high + bias], "slope": slope, "bias": bias}
    return {"run": run.run_id, "system": run.system, "curves": curves, "lines": lines, "output_range_n": run.output_range_n}


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


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of the named run, or of the first."""
    found = next((r for r in inputs.log if run is None or r.run_id == run), None)
    return data(found, inputs.phases.get(found.run_id), fit_of(inputs, found)) if found else None


def fit_of(inputs: Inputs, run: RunView) -> dict[str, Any] | None:
    """Return the Theta row of a run: by run_id, else by configuration and system if there is just one."""
    rows = [t for t in inputs.theta if t["run_id"] == run.run_id]
    if not rows and run.config_id is not None:
        rows = [t for t in inputs.theta if (t["config_id"], t["system"]) == (run.config_id, run.system)]
    return rows[0] if len(rows) == 1 else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw one loop on one pair of axes."""
    for name, (x, y) in data["curves"].items():
        colour = palette.PHASES.get(name, palette.BLUE if name == "all" else palette.GREY)
        text = f"{name} ({palette.PHASE_NAMES[name]})" if name in palette.PHASE_NAMES else None
        axes.plot(x, y, color=colour, label=text, linewidth=1.5)
    for name, line in data["lines"].items():
        sign = "+" if line["bias"] >= 0 else "−"
        axes.plot(
            line["x"],
            line["y"],
            color=palette.INK,
            linestyle="--" if name == "pull" else ":",
            linewidth=1.2,
            label=f"{name} fit: {line['slope']:.3f} in {sign} {abs(line['bias']):.2f} N",
        )
    # a fitted line runs far beyond the loop at its unused end: the loop decides the scale
    bottom, top = data["output_range_n"]
    if top > bottom:
        axes.set_ylim(bottom - 0.06 * (top - bottom), top + 0.06 * (top - bottom))
    axes.set_xlabel("input tension / N")
    axes.set_ylabel("output tension / N")
    axes.set_title(label(f"{data['run']} ({data['system']})", 52), loc="left")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=2, columnspacing=1.2, handlelength=1.6, fontsize=8)


def alt(data: dict[str, Any]) -> str:
    """Describe the loop in words."""
    text = f"Hysteresis loop of run {data['run']} ({data['system']}), output against input tension"
    phases = [n for n in data["curves"] if n in palette.PHASES]
    text += f", coloured by phase {', '.join(phases)}" if phases else ""
    for name, line in data["lines"].items():
        text += f"; fitted {name} line with slope {line['slope']:.3f} and bias {line['bias']:.2f} N"
    return text + "."

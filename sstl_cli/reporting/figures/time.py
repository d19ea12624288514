"""Input and output tension over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.figures.loop import by_phase
from sstl_cli.reporting.inputs import Array, Inputs, RunView, Segments

NEEDS = ("log",)


@dataclass(frozen=True)
class Tensions:
    """Input (N) over time (s), and the output as one polyline a phase."""

    run: str
    time_s: Array
    input_n: Array
    output: dict[str, tuple[Array, Array]]


def data(run: RunView, phases: Segments | None = None) -> Tensions:
    """Return both tensions; the output split by phase where phases are given."""
    x, y = run.time_s, run.tension_out_n
    curves = {"all": (x, y)} if phases is None else by_phase(x, y, phases.at(x))
    return Tensions(run.run_id, x, run.tension_in_n, curves)


def default(inputs: Inputs, run: str | None) -> Tensions | None:
    """Return the data of the named run, or of the first."""
    found = next((r for r in inputs.log if run is None or r.run_id == run), None)
    return data(found, inputs.phases.get(found.run_id)) if found else None


def figure(data: Tensions) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: Tensions) -> None:
    """Draw both tensions on one pair of axes."""
    axes.plot(data.time_s, data.input_n, color=palette.INK, linewidth=1.1, label="input")
    for name, (x, y) in data.output.items():
        colour = palette.PHASES.get(name, palette.BLUE if name == "all" else palette.GREY)
        axes.plot(x, y, color=colour, label="output" if name == "all" else f"output, {name}")
    axes.set_xlabel("time / s")
    axes.set_ylabel("tension / N")
    axes.set_title(label(data.run, 52), loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=3, columnspacing=1.2, handlelength=1.6, fontsize=8)


def alt(data: Tensions) -> str:
    """Describe the plot in words."""
    return f"Input and output tension of run {data.run} over {data.time_s[-1] - data.time_s[0]:.3g} s."

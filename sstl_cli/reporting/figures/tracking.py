"""Tracking: reference, outputs of the methods and their errors over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Array, CommandView, Inputs

NEEDS = ("command",)
ORDER = list(palette.METHODS)


@dataclass(frozen=True)
class Track:
    """Output and error (output minus reference) of one method in N over time in s."""

    time_s: Array
    output_n: Array
    error_n: Array
    rmse_n: float


@dataclass(frozen=True)
class Tracking:
    """One run: the reference (time, tension), and what each method makes of it."""

    run: str
    reference: tuple[Array, Array]
    methods: dict[str, Track]


def data(views: list[CommandView]) -> Tracking:
    """Return the methods in the order in which they are known."""
    ordered = sorted(views, key=lambda v: (ORDER.index(v.method) if v.method in ORDER else 99, v.method))
    longest = max(views, key=lambda v: v.time_s[-1] - v.time_s[0])
    methods = {v.method: Track(v.time_s, v.output_n, v.output_n - v.reference_n, v.rmse_n) for v in ordered}
    return Tracking(views[0].subject, (longest.time_s, longest.reference_n), methods)


def default(inputs: Inputs, run: str | None) -> Tracking | None:
    """Return the data of the named run, or of the first."""
    name = run if run is not None or not inputs.command else inputs.command[0].subject
    views = [v for v in inputs.command if name in (v.subject, v.run_id)]
    return data(views) if views else None


def figure(data: Tracking) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, 5.2), (2, 1)


def draw(axes: Any, data: Tracking) -> None:
    """Draw outputs above and errors below, the same colour for a method in both."""
    top, bottom = axes[0, 0], axes[1, 0]
    top.plot(*data.reference, color=palette.INK, linewidth=1.2, label="reference")
    names = list(data.methods)
    for name, m in data.methods.items():
        look = {"color": palette.of(name, palette.METHODS, names), "linestyle": palette.METHOD_STYLES.get(name, ":")}
        top.plot(m.time_s, m.output_n, label=label(f"{name} (RMSE {m.rmse_n:.3g} N)", 40), **look)
        bottom.plot(m.time_s, m.error_n, **look)
    bottom.axhline(0.0, color=palette.INK, linewidth=0.8)
    top.set_ylabel("output tension / N")
    bottom.set_ylabel("error / N")
    for panel in (top, bottom):
        panel.set_xlabel("time / s")
    top.set_title(label(data.run, 60), loc="left")
    top.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def alt(data: Tracking) -> str:
    """Describe the picture in words."""
    parts = [f"{name} {m.rmse_n:.3g} N" for name, m in data.methods.items()]
    return f"Reference, output and error over time of run {data.run}; RMSE: " + ", ".join(parts) + "."

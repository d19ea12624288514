"""The four loop parameters over lead and location, with error bars."""

from __future__ import annotations

from typing import Any

from sstl_cli.core.tables import PARAMETERS
from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number
from sstl_cli.reporting.drawing import label
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("theta",)
SYMBOLS = {"gamma_p": "Γ pull / 1", "gamma_r": "Γ release / 1", "beta_p": "β pull / N", "beta_r": "β release / N"}


def data(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return, for every (system, location), lead in mm (place in file where null) and each parameter with its error."""
    leads = [number(r.get("lead_mm")) for r in rows]
    by_lead = any(v == v for v in leads)
    series: dict[tuple[str, str], dict[str, list[float]]] = {}
    for place, row in enumerate(rows):
        x = leads[place] if by_lead else float(place)
        if x != x:
            continue
        group = series.setdefault((str(row["system"]), str(row.get("location") or "–")), {"x": []})
        group["x"].append(x)
        for p in PARAMETERS:
            group.setdefault(p, []).append(number(row.get(p)))
            group.setdefault(p + "_se", []).append(number(row.get(p + "_se")))
    return {"series": dict(sorted(series.items())), "by_lead": by_lead}


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of all rows."""
    return data(inputs.theta) if inputs.theta and run is None else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (8.2, 6.0), (2, 2)


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw one parameter a panel; error bars are one standard error."""
    locations = sorted({location for _, location in data["series"]})
    for panel, p in zip(axes.flat, ("gamma_p", "gamma_r", "beta_p", "beta_r"), strict=True):
        for (system, location), group in data["series"].items():
            colour = palette.of(location, palette.LOCATIONS, locations)
            errors = [0.0 if e != e else e for e in group[p + "_se"]]
            panel.errorbar(
                group["x"],
                group[p],
                yerr=errors,
                fmt=palette.SYSTEM_MARKERS.get(system, "^"),
                color=colour,
                markersize=4.5,
                markerfacecolor=colour if system == "act" else palette.PAPER,
                elinewidth=1,
                capsize=2,
                linestyle="none",
                label=label(f"{system} {location}"),
            )
        panel.set_ylabel(SYMBOLS[p])
        panel.set_xlabel("lead-screw displacement / mm" if data["by_lead"] else "row in file / 1")
    handles, names = axes[0, 0].get_legend_handles_labels()
    axes[0, 0].figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 6))


def alt(data: dict[str, Any]) -> str:
    """Describe the picture in words."""
    n = sum(len(g["x"]) for g in data["series"].values())
    names = ", ".join(f"{s} {location}" for s, location in data["series"])
    return f"Slopes and biases of pull and release lines of {n} runs with standard errors, for {names}."

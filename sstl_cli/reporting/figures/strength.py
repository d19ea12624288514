"""Scores of the blind check over the strength of the withheld effect."""

from __future__ import annotations

from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.documents import number, rows, share
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("blind",)
SCORES = {
    "isolation": ("isolation", palette.GREEN, "-", "o"),
    "false_alarm": ("false alarm", palette.VERMILLION, "--", "s"),
    "wrong_commits": ("wrong commits", palette.PURPLE, "-.", "^"),
    "unknown_recall": ("unknown recall", palette.BLUE, ":", "D"),
}


def data(document: dict[str, Any]) -> dict[str, Any]:
    """Return, by score, strength (gap over noise RMS) with share, its interval and n; strengths ascending."""
    found: dict[str, dict[str, list[float]]] = {}
    levels = [r for r in rows(document, "by_strength") if number(r.get("strength")) == number(r.get("strength"))]
    for row in sorted(levels, key=lambda r: number(r.get("strength"))):
        for score in SCORES:
            middle, low, high, n = share(row.get(score))
            if middle == middle:
                curve = found.setdefault(score, {"strength": [], "share": [], "low": [], "high": [], "n": []})
                for key, value in zip(curve, (number(row["strength"]), middle, low, high, n), strict=True):
                    curve[key].append(value)
    return {"scores": found}


def default(inputs: Inputs, run: str | None) -> dict[str, Any] | None:
    """Return the data of the first blind result."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else {"scores": {}}
    return found if found["scores"] else None


def figure(data: dict[str, Any]) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: dict[str, Any]) -> None:
    """Draw one curve a score with its interval, slightly apart so that intervals do not hide one another."""
    positive = all(s > 0 for c in data["scores"].values() for s in c["strength"])
    for k, (score, curve) in enumerate(data["scores"].items()):
        name, colour, style, marker = SCORES[score]
        x = [s * 1.03**k if positive else s for s in curve["strength"]]
        below = [max(0.0, s - low) for s, low in zip(curve["share"], curve["low"], strict=True)]
        above = [max(0.0, high - s) for s, high in zip(curve["share"], curve["high"], strict=True)]
        axes.errorbar(
            x,
            curve["share"],
            yerr=[below, above],
            color=colour,
            linestyle=style,
            marker=marker,
            markersize=5,
            capsize=2.5,
            elinewidth=1,
            label=name,
        )
    if positive:
        axes.set_xscale("log")
        ticks = sorted({s for c in data["scores"].values() for s in c["strength"]})
        axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
        axes.minorticks_off()
    axes.set_ylim(-0.03, 1.05)
    axes.set_xlabel("strength: gap over noise RMS / 1")
    axes.set_ylabel("share of cases / 1")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=2)


def alt(data: dict[str, Any]) -> str:
    """Describe the curves in words."""
    parts = [
        f"{SCORES[s][0]} " + ", ".join(f"{y:.2f} at {x:g}" for x, y in zip(c["strength"], c["share"], strict=True))
        for s, c in data["scores"].items()
    ]
    return "Scores over strength: " + "; ".join(parts) + "."

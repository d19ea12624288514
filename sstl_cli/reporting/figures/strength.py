"""Scores of the blind check over the strength of the withheld effect."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from sstl_cli.reporting import palette
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.scored import Scored

NEEDS = ("blind",)
SCORES = {
    "isolation": ("isolation", palette.GREEN, "-", "o"),
    "false_alarm": ("false alarm", palette.VERMILLION, "--", "s"),
    "wrong_commits": ("wrong commits", palette.PURPLE, "-.", "^"),
    "unknown_recall": ("unknown recall", palette.BLUE, ":", "D"),
}


@dataclass(frozen=True)
class Curve:
    """One score over the strength (gap over noise RMS): share, its interval and the number of cases."""

    strength: list[float] = field(default_factory=list)
    share: list[float] = field(default_factory=list)
    low: list[float] = field(default_factory=list)
    high: list[float] = field(default_factory=list)
    n: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Curves:
    """A curve by score, as far as the document has them; strengths ascending."""

    scores: dict[str, Curve]


def data(document: Scored) -> Curves:
    """Return the shares of every score."""
    found: dict[str, Curve] = {}
    levels = [r for r in document.by_strength if r.strength == r.strength]
    for row in sorted(levels, key=lambda r: r.strength):
        for score in SCORES:
            rate = row.of(score)
            if rate.share == rate.share:
                curve = found.setdefault(score, Curve())
                curve.strength.append(row.strength)
                for name in ("share", "low", "high", "n"):
                    getattr(curve, name).append(getattr(rate, name))
    return Curves(found)


def default(inputs: Inputs, run: str | None) -> Curves | None:
    """Return the data of the first blind result."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else None
    return found if found is not None and found.scores else None


def figure(data: Curves) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (4.6, 3.7), (1, 1)


def draw(axes: Any, data: Curves) -> None:
    """Draw one curve a score with its interval, slightly apart so that intervals do not hide one another."""
    positive = all(s > 0 for c in data.scores.values() for s in c.strength)
    for k, (score, curve) in enumerate(data.scores.items()):
        name, colour, style, marker = SCORES[score]
        x = [s * 1.03**k if positive else s for s in curve.strength]
        below = [max(0.0, s - low) for s, low in zip(curve.share, curve.low, strict=True)]
        above = [max(0.0, high - s) for s, high in zip(curve.share, curve.high, strict=True)]
        axes.errorbar(
            x,
            curve.share,
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
        ticks = sorted({s for c in data.scores.values() for s in c.strength})
        axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
        axes.minorticks_off()
    axes.set_ylim(-0.03, 1.05)
    axes.set_xlabel("strength: gap over noise RMS / 1")
    axes.set_ylabel("share of cases / 1")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.17), ncols=2)


def alt(data: Curves) -> str:
    """Describe the curves in words."""
    parts = [
        f"{SCORES[s][0]} " + ", ".join(f"{y:.2f} at {x:g}" for x, y in zip(c.strength, c.share, strict=True))
        for s, c in data.scores.items()
    ]
    return "Scores over strength: " + "; ".join(parts) + "."

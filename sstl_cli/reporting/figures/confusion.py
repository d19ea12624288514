"""Confusion matrix of the blind check: what was withheld against what was named."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sstl_cli.reporting.documents import NAN, Matrix, square
from sstl_cli.reporting.drawing import heat
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.scored import Scored

NEEDS = ("blind",)


@dataclass(frozen=True)
class Confused:
    """Truth by row, verdict by column: counts, shares of each row in %, and the share of all cases on the diagonal in %."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    counts: Matrix
    share_pct: list[list[float]]
    right_pct: float


def data(document: Scored) -> Confused:
    """Return the matrix with its shares; a row without cases has zero shares."""
    found = document.confusion
    rows, columns = found.labels, found.columns or found.labels
    counts = square(found.matrix, len(rows), len(columns), "matrix")
    sums = [sum(v for v in row if v == v) for row in counts]
    share = [[100 * v / s if s and v == v else 0.0 for v in row] for row, s in zip(counts, sums, strict=True)]
    right = sum(counts[i][columns.index(r)] for i, r in enumerate(rows) if r in columns)
    return Confused(rows, columns, counts, share, 100 * right / sum(sums) if sum(sums) else NAN)


def default(inputs: Inputs, run: str | None) -> Confused | None:
    """Return the data of the first blind result."""
    found = data(inputs.blind[0]) if inputs.blind and run is None else None
    return found if found is not None and found.rows else None


def figure(data: Confused) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    return (max(4.6, 2.1 + 0.31 * len(data.columns)), max(3.6, 1.9 + 0.26 * len(data.rows))), (1, 1)


def draw(axes: Any, data: Confused) -> None:
    """Draw the counts as cells."""
    top = max((v for row in data.counts for v in row if v == v), default=1.0)
    heat(axes, data.counts, data.rows, data.columns, "{:.0f}", top)
    axes.set_xlabel("named by the diagnosis")
    axes.set_ylabel("withheld (truth)")
    axes.set_title("cases / 1", loc="left")


def alt(data: Confused) -> str:
    """Describe the matrix by its diagonal and its largest confusion."""
    wrong = [
        (v, r, c) for r, row in zip(data.rows, data.counts, strict=True) for c, v in zip(data.columns, row, strict=True) if r != c and v > 0
    ]
    worst = max(wrong, default=None)
    text = f"Confusion matrix of {len(data.rows)} truths; {data.right_pct:.1f} % of cases on the diagonal"
    return text + (f"; most often confused: {worst[1]} named {worst[2]} ({worst[0]:.0f})." if worst else ".")

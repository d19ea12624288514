"""Which effects this excitation can tell apart: cosine between their responses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.documents import Matrix, square
from sstl_cli.reporting.drawing import heat
from sstl_cli.reporting.inputs import Inputs

NEEDS = ("diagnosis",)


@dataclass(frozen=True)
class Cosines:
    """Effects, the cosines between their responses, and the pairs above 0.95 (nearly the same response)."""

    ids: tuple[str, ...]
    cosine: Matrix
    twins: list[tuple[str, str, float]]


def data(document: Diagnosed) -> Cosines:
    """Return the matrix of cosines and its largest entries."""
    ids = document.isolability.ids
    cosine = square(document.isolability.cosine, len(ids), len(ids), "cosine")
    twins = [(ids[i], ids[j], cosine[i][j]) for i in range(len(ids)) for j in range(i) if abs(cosine[i][j]) > 0.95]
    return Cosines(ids, cosine, sorted(twins, key=lambda t: -abs(t[2])))


def default(inputs: Inputs, run: str | None) -> Cosines | None:
    """Return the data of the first diagnosis."""
    found = data(inputs.diagnosis[0]) if inputs.diagnosis and run is None else None
    return found if found is not None and found.ids else None


def figure(data: Cosines) -> tuple[tuple[float, float], tuple[int, int]]:
    """Return size in inch and grid."""
    n = len(data.ids)
    return (max(4.6, 1.9 + 0.33 * n), max(3.6, 1.7 + 0.27 * n)), (1, 1)


def draw(axes: Any, data: Cosines) -> None:
    """Draw the matrix as cells with their numbers."""
    heat(axes, data.cosine, data.ids, data.ids, "{:.2f}", 1.0)
    axes.set_title("cosine between responses / 1", loc="left")


def alt(data: Cosines) -> str:
    """Describe the matrix by the pairs that cannot be told apart."""
    twins = ", ".join(f"{a} and {b} ({c:.2f})" for a, b, c in data.twins[:6])
    return f"Isolability of {len(data.ids)} effects; hard to tell apart: {twins or 'none'}."

"""The same rates side by side: each simulator and all together, and the cases that the recordings could decide."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from sstl_cli.blind.judge import NAMED, Judged, of, share
from sstl_cli.blind.score import reliability, scores
from sstl_cli.blind.strength import STRENGTHS

ALL = "all"


def document(cases: Sequence[Judged], decidable: Collection[str] | None = None) -> dict[str, Any]:
    """Return ``by_simulator`` and, where the decidable cases are known, ``decidable``: rows of rates, all cases last."""
    body: dict[str, Any] = {"by_simulator": rows(cases), "decidable": None}
    if decidable is not None:
        # where nothing is missing there is nothing to decide between: those cases stay
        body["decidable"] = rows([c for c in cases if c.kind == "none" or c.case in decidable])
    return body


def rows(cases: Sequence[Judged]) -> list[dict[str, Any]]:
    """Return the rates of each simulator, and of all together in the last row."""
    names = sorted({simulator(c) for c in cases})
    found = [_row(n, [c for c in cases if simulator(c) == n]) for n in names]
    return [*found, _row(ALL, list(cases))]


def simulator(c: Judged) -> str:
    """Return what stood in for hardware; sets from before there were several come from the rig."""
    return str(c.truth.get("simulator", "rig"))


def _row(name: str, cases: Sequence[Judged]) -> dict[str, Any]:
    single = of(cases, "single")
    by_strength = {f"{s:g}": share(c.exact for c in single if c.band == s) for s in STRENGTHS}
    in_group = {f"{s:g}": share(c.status in NAMED and c.covered for c in single if c.band == s) for s in STRENGTHS}
    return {
        "simulator": name,
        "cases": len(cases),
        "scores": scores(cases, reliability(cases)[1]),
        "isolation": by_strength,
        "in_group": in_group,
    }

"""Published numbers beside ours, with a verdict for each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import pyarrow as pa

from sstl_cli.core.tables import Column, Schema
from sstl_cli.paper import origin
from sstl_cli.paper.published import Entry

Key = tuple[str, str, str]
MET, CONTRADICTED, DIFFERS, UNJUDGED = "met", "contradicted", "differs", "not judged"
VERDICTS = {
    MET: "within 2 sd of its sampling spread (and rounding)",
    CONTRADICTED: "not met, but the paper contradicts itself here",
    DIFFERS: "not met",
    UNJUDGED: "no sampling spread at hand",
}
BOUND_SD = 2.0
STALE_SD = 5.0
STATED, FITTED = "stated", "fitted"
_S, _F = pa.string(), pa.float64()
COMPARISON = Schema(
    "sstl.comparison",
    1,
    (
        Column("table", _S, meaning="I, II, bias, III, range, IV or summary"),
        Column("block", _S, meaning="settings of our value: stated, fitted, or rig"),
        Column("row", _S),
        Column("column", _S),
        Column("published", _F, nullable=True, meaning="as printed"),
        Column("published_spread", _F, nullable=True, meaning="printed behind the value"),
        Column("ours", _F, nullable=True),
        Column("ours_mean", _F, nullable=True, meaning="mean of ours over seeds"),
        Column("ours_sd", _F, nullable=True, meaning="standard deviation of ours over seeds"),
        Column("difference", _F, nullable=True, meaning="ours minus published"),
        Column("verdict", _S),
        Column("reason", _S, meaning="why the paper contradicts itself, or how far ours differs"),
        Column("origin", _S, meaning="fitted: constants behind our value were set to this entry; else predicted"),
    ),
)


@dataclass(frozen=True)
class Compared:
    """One published number beside ours; ``mean`` and ``sd`` are those of ours over seeds."""

    entry: Entry
    ours: float | None
    mean: float | None
    sd: float | None
    verdict: str
    reason: str
    block: str = STATED

    @property
    def difference(self) -> float | None:
        return None if self.ours is None else self.ours - self.entry.value

    @property
    def relative_pct(self) -> float | None:
        """How far the mean of ours lies from the published value, in percent of it."""
        return None if self.mean is None or not self.entry.value else 100.0 * (self.mean / self.entry.value - 1.0)

    @property
    def origin(self) -> str:
        """Whether our value was fitted to this entry or is predicted."""
        return origin.of(self.block, (self.entry.table, self.entry.row, self.entry.column))

    def record(self) -> dict[str, object]:
        """Return the row of the COMPARISON schema."""
        e = self.entry
        return {
            "table": e.table,
            "block": self.block,
            "row": e.row,
            "column": e.column,
            "published": e.value,
            "published_spread": e.spread,
            "ours": self.ours,
            "ours_mean": self.mean,
            "ours_sd": self.sd,
            "difference": self.difference,
            "verdict": self.verdict,
            "reason": self.reason,
            "origin": self.origin,
        }


def compare(
    published: Iterable[Entry], ours: Mapping[Key, float], spread: Mapping[Key, tuple[float, float]], block: str = STATED
) -> list[Compared]:
    """Return every published entry beside ours; entries we have no value for are not judged.

    Parameters
    ----------
    spread : mapping
        Mean and standard deviation of ours from one seed to the next, by entry.
    """
    done = []
    for entry in published:
        key = (entry.table, entry.row, entry.column)
        value = ours.get(key)
        mean, sd = spread.get(key, (None, None))
        # what contradicts the stated settings may hold under fitted ones; the rig tracks the stated references
        under = replace(entry, contradicted="") if block == FITTED else entry
        verdict, reason = judge(under, value, mean, sd)
        done.append(Compared(entry, value, mean, sd, verdict, reason, block))
    return done


def judge(entry: Entry, value: float | None, mean: float | None, sd: float | None) -> tuple[str, str]:
    """Return verdict and reason: whether the published value lies within 2 sd of our mean over seeds.

    Our value at hand must itself lie within 5 sd of that mean: else the stored spread is not of this program.
    """
    if value is None or mean is None or sd is None:
        return UNJUDGED, "no value of ours" if value is None else "no sampling spread"
    if abs(value - mean) > STALE_SD * sd + entry.rounding:
        return (DIFFERS, f"ours is {value:.4g}, but the stored spread says {mean:.4g} +- {sd:.2g}: run sstl reproduce --spread")
    off = mean - entry.value
    relative = f", {100.0 * off / abs(entry.value):+.1f} %" if entry.value else ""
    if abs(off) <= BOUND_SD * sd + entry.rounding:
        return MET, entry.contradicted
    if entry.contradicted:
        return CONTRADICTED, entry.contradicted
    times = f"{abs(off) / sd:.1f} sd" if sd > 0 else "no spread"
    return DIFFERS, f"differs by {off:+.3g} ({times}{relative})"


def table_of(compared: Iterable[Compared]) -> pa.Table:
    """Return compared entries as a table of the COMPARISON schema."""
    return pa.Table.from_pylist([c.record() for c in compared], schema=COMPARISON.arrow())


def count(compared: Iterable[Compared]) -> dict[str, int]:
    """Return how many entries have each verdict."""
    found = dict.fromkeys(VERDICTS, 0)
    for c in compared:
        found[c.verdict] += 1
    return found


def count_apart(compared: Iterable[Compared]) -> dict[tuple[str, str, str], dict[str, int]]:
    """Return how many entries have each verdict, by block, table and origin (fitted or predicted)."""
    found: dict[tuple[str, str, str], dict[str, int]] = {}
    for c in compared:
        found.setdefault((c.block, c.entry.table, c.origin), dict.fromkeys(VERDICTS, 0))[c.verdict] += 1
    return found

"""The paper's numbers as data: one entry per printed number, with what the paper says against it itself."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources

from sstl_cli.paper import contradictions

TABLES = ("I", "II", "bias", "III", "range", "IV", "summary", "headline")


@dataclass(frozen=True)
class Entry:
    """One printed number: value, the spread printed behind it, and why it cannot be right (empty if it can)."""

    table: str
    row: str
    column: str
    value: float
    decimals: int
    spread: float | None = None
    contradicted: str = ""

    @property
    def rounding(self) -> float:
        """Half a unit of the last printed digit."""
        return 0.5 * 10.0**-self.decimals

    def text(self) -> str:
        """Return the number as printed."""
        return f"{self.value:.{self.decimals}f}"


@cache
def entries() -> tuple[Entry, ...]:
    """Return every published number, in the order of the paper."""
    document = tomllib.loads((resources.files("sstl_cli.paper") / "published.toml").read_text(encoding="utf-8"))
    plain = [
        Entry(table, row, column, float(value), digits, _at(document[table].get("spread", {}).get(row, []), i))
        for table in TABLES
        for row, values in document[table]["rows"].items()
        for i, (column, digits, value) in enumerate(zip(document[table]["columns"], document[table]["decimals"], values, strict=False))
    ]
    numbers = {(e.table, e.row, e.column): e.value for e in plain}
    reasons = contradictions.find(numbers)
    return tuple(Entry(e.table, e.row, e.column, e.value, e.decimals, e.spread, reasons.get((e.table, e.row, e.column), "")) for e in plain)


@cache
def titles() -> dict[str, str]:
    """Return the title of every table."""
    document = tomllib.loads((resources.files("sstl_cli.paper") / "published.toml").read_text(encoding="utf-8"))
    return {t: str(document[t]["title"]) for t in TABLES}


def of_table(table: str) -> tuple[Entry, ...]:
    """Return the entries of one table."""
    return tuple(e for e in entries() if e.table == table)


def value(table: str, row: str, column: str) -> float:
    """Return one published number; KeyError if the paper does not print it."""
    for e in entries():
        if (e.table, e.row, e.column) == (table, row, column):
            return e.value
    raise KeyError((table, row, column))


def _at(values: list[float], i: int) -> float | None:
    return float(values[i]) if i < len(values) else None

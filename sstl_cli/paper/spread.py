"""The stored sampling spread: mean and standard deviation of every entry over data seeds.

``spread.csv`` beside this file is written by ``sstl reproduce --spread``; nothing else edits it.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, field
from importlib import resources

Key = tuple[str, str, str]
Moments = dict[Key, tuple[float, float]]
HEADER = ("block", "table", "row", "column", "mean", "sd", "seeds")


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation by block and entry, over ``seeds`` data sets."""

    blocks: dict[str, Moments] = field(default_factory=dict)
    seeds: int = 0

    def of(self, block: str) -> Moments:
        """Return the entries of one block (empty if nothing is stored)."""
        return self.blocks.get(block, {})

    def csv(self) -> str:
        """Return the file's text."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(HEADER)
        for block, moments in self.blocks.items():
            for key, (mean, sd) in moments.items():
                writer.writerow([block, *key, f"{mean:.6g}", f"{sd:.4g}", self.seeds])
        return text.getvalue()


def parse(text: str) -> Spread:
    """Return the spread that a file's text holds."""
    blocks: dict[str, Moments] = {}
    seeds = 0
    for row in csv.DictReader(io.StringIO(text)):
        blocks.setdefault(row["block"], {})[row["table"], row["row"], row["column"]] = (
            float(row["mean"]),
            float(row["sd"]),
        )
        seeds = int(row["seeds"])
    return Spread(blocks, seeds)


def stored() -> Spread:
    """Return the spread that comes with the package (empty if the file is missing)."""
    file = resources.files("sstl_cli.paper") / "spread.csv"
    return parse(file.read_text(encoding="utf-8")) if file.is_file() else Spread()

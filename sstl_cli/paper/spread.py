"""The stored sampling spread: mean and standard deviation of every entry over data seeds.

The files beside this one are written by ``sstl reproduce --spread``; nothing else edits them.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources

import numpy as np

Key = tuple[str, str, str]
Moments = dict[Key, tuple[float, float]]
#: entries of one data seed by block
Draw = Mapping[str, Mapping[Key, float]]
HEADER = ("block", "table", "row", "column", "mean", "sd", "seeds")
#: file by experiment: the generator's tables, block R, Table III over data sets
FILES = {"generator": "spread.csv", "R": "spread_rig.csv", "III": "spread_mapping.csv"}


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


def of_draws(draws: Sequence[Draw]) -> Spread:
    """Return mean and standard deviation of every entry over the draws of as many data seeds (0 for one alone)."""
    blocks = {
        block: {
            key: (float(np.mean(values)), float(np.std(values, ddof=1)) if len(draws) > 1 else 0.0)
            for key in entries
            for values in [[draw[block][key] for draw in draws]]
        }
        for block, entries in draws[0].items()
    }
    return Spread(blocks, len(draws))


def parse(text: str) -> Spread:
    """Return the spread that a file's text holds."""
    blocks: dict[str, Moments] = {}
    seeds = 0
    for row in csv.DictReader(io.StringIO(text)):
        blocks.setdefault(row["block"], {})[row["table"], row["row"], row["column"]] = (float(row["mean"]), float(row["sd"]))
        seeds = int(row["seeds"])
    return Spread(blocks, seeds)


def stored(experiment: str = "generator") -> Spread:
    """Return the spread of an experiment that comes with the package (empty if the file is missing)."""
    file = resources.files("sstl_cli.paper") / FILES[experiment]
    return parse(file.read_text(encoding="utf-8")) if file.is_file() else Spread()

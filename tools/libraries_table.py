"""What a change of the likelihood is worth: two libraries of the same cases side by side, into docs/measured.md.

python tools/libraries_table.py BEFORE AFTER    (folders with library-*.parquet; git has the earlier ones)
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from page_part import put, table

from sstl_cli.blind import learning
from sstl_cli.blind.learning import Example
from sstl_cli.blind.library import read_library
from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN
from sstl_cli.diagnosis.features import OUTPUT
from sstl_cli.diagnosis.verdict import Verdict, decided
from sstl_cli.steps.blind_learn import told

# upper edges of the nominal strengths 0.4, 1.2 and 4 times the noise
BANDS = ((0.6, "0.4"), (2.2, "1.2"), (8.0, "4"), (np.inf, "12, 40"))
SHOWN = ("truth first", "margin (nats)", "exact", "in the set", "none", "unknown", "wrong")


@dataclass(frozen=True)
class Judged:
    """A case, and what weights of the other simulators say of it."""

    example: Example
    verdict: Verdict

    @property
    def row(self) -> str:
        """Return the row of the table that the case belongs to."""
        answer = self.example.answer
        if answer == NONE:
            return "nothing missing"
        if answer == UNKNOWN:
            return "cause not among the candidates"
        return ("pair" if len(answer) > 1 else "single") + ", " + next(name for edge, name in BANDS if self.example.strength < edge)

    @property
    def margin(self) -> float | None:
        """Return the evidence of the truth over the best other model that does not contain it; None beside the output."""
        fitted = [c for c in self.example.rows.candidates if c.kind == OUTPUT]
        own = [c.evidence for c in fitted if c.ids == self.example.answer]
        rest = [c.evidence for c in fitted if not set(c.ids) >= set(self.example.answer)]
        return own[0] - max([0.0, *rest]) if own else None


def library(folder: Path) -> list[Example]:
    """Return the examples of the libraries of a folder."""
    return told([case for path in sorted(folder.glob("library-*.parquet")) for case in read_library(path)])


def judged(examples: Sequence[Example]) -> list[Judged]:
    """Return what is said of every case by weights learned without its simulator."""
    found = learning.judged_by(examples, learning.left_out(examples))
    weights = learning.calibrated(found, learning.learn(examples, {}), found)
    return [Judged(e, decided(e.rows, p, weights)) for e, p in found]


def cells(cases: Sequence[Judged]) -> list[str]:
    """Return the cells of a row: counts, and the median margin."""
    margins = [j.margin for j in cases if j.margin is not None and j.example.answer not in (NONE, UNKNOWN)]

    def count(which: Callable[[Judged], bool]) -> str:
        return str(sum(which(j) for j in cases))

    return [
        f"{sum(m > 0.0 for m in margins)} of {len(margins)}" if margins else "-",
        f"{np.median(margins):.1f}" if margins else "-",
        count(lambda j: j.verdict.status == "identified" and set(j.verdict.effects) == set(j.example.answer)) if margins else "-",
        count(lambda j: set(j.example.answer) <= {i for ids in j.verdict.group for i in ids}) if margins else "-",
        count(lambda j: j.verdict.status == "none"),
        count(lambda j: j.verdict.status == "unknown"),
        count(lambda j: learning.is_wrong(j.example, j.verdict)),
    ]


def main() -> None:
    """Put the table into docs/measured.md."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs=2, metavar="FOLDER")
    found = [library(f) for f in parser.parse_args().folders]
    common = set.intersection(*({e.name for e in examples} for examples in found))
    rows: dict[str, dict[str, list[Judged]]] = defaultdict(dict)
    for name, examples in zip(("before", "after"), found, strict=True):
        for j in judged([e for e in examples if e.name in common]):
            rows[j.row].setdefault(name, []).append(j)
    lines: list[list[object]] = [[row, len(cases), name, *cells(cases)] for row in sorted(rows) for name, cases in rows[row].items()]
    put("measured.md", "libraries", table(["case", "cases", "likelihood", *SHOWN], lines))


if __name__ == "__main__":
    main()

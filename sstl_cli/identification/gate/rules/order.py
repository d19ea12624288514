"""Samples without an order: both channels jump from one end to the other at every sample, and still belong to each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "order", 1
# steps over those of samples in any order (1), how input and output must belong together sample by sample, and what they must move by
ANY, TOGETHER, WIDE = 0.7, 0.3, 0.2

# part of samples that are whole numbers
WHOLE = 0.9
SEEN = {
    "value": "one channel never falls (or never rises) while the other one goes to and fro at every sample; the rows were probably sorted by a tension",
    "text": "a good many rows stand off both neighbours in both channels and belong to other times; the rows were probably sorted as text (1, 10, 100, 2)",
    "interleaved": "the samples go to and fro between two movements, each like the one before the last and unlike the last; two recordings were probably interleaved",
}


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose samples do not follow each other."""
    hit = [e for e in log if e.usable and e.both_tensions and _shuffled(e)]
    if hit:
        number = min(min(e.roughness) for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "failure", number, "1",
            f"{names([e.run_id for e in hit])}: from one sample to the next both channels go as far as from any sample to any other "
            f"({number:.2g} of it), and still rise and fall together; the rows were probably shuffled or sorted by another column",
            "sort the rows by their clock or number before the import (clock and channels together)",
        )  # fmt: skip

    for kind, seen in SEEN.items():
        hit = [e for e in log if e.usable and e.both_tensions and e.disorder == kind and not _shuffled(e) and not _numbered(e)]
        if hit:
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", float(len(hit)), "1",
                f"{names([e.run_id for e in hit])}: {seen}",
                "sort the rows by their clock or number before the import (clock and channels together)",
            )  # fmt: skip


def _numbered(e: Evidence) -> bool:
    """Whether a channel holds whole numbers: a decimal comma that was lost makes single readings stand off as well."""
    return max(e.whole_share) > WHOLE


def _shuffled(e: Evidence) -> bool:
    """Whether no sample is like the one before though the channels are like each other: noise alone is not."""
    moves = all(r.span > WIDE * r.largest for r in e.ranges)
    return moves and min(e.roughness) > ANY and abs(e.raw_correlation) > TOGETHER

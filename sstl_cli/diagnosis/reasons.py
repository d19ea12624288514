"""How much of a gap a candidate carries, and why it is said to be its cause or is not."""

from __future__ import annotations

import numpy as np

from sstl_cli.diagnosis import nameless
from sstl_cli.diagnosis.constants import DECIDES_NATS, HALF, LEAST_SHARE, MOST_SIGMA
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.features import BESIDE, OUTPUT, RECORDER, CandidateRow, Ids, Rows, leading
from sstl_cli.diagnosis.fit import Fit, jumping
from sstl_cli.diagnosis.found import Search
from sstl_cli.physics.effects import catalogue, get


def carried(c: CandidateRow, rows: Rows) -> float:
    """Return what a candidate takes off the squared error beyond the noise; of the recorder that is what it is named for.

    Counted in units of the noise where it is met, with what the candidate's own law leaves open (jumps at unknown moments), and no
    more than by size. Where a simulator is known to leave more in some places than in others size is that of the largest: there it only
    says who comes no nearer at all. What was held out has the same say: no candidate takes off more than it may at most remove there.
    Not of jumps, which nobody can foretell, as long as they leave no more than the noise and their mean is not surely further off than
    the base: of all predictions the mean leaves the least. Where the output is seen to rest and jump, it need not be nearer on the whole.
    """
    if c.kind == OUTPUT:
        left, share = _accounted(c, rows)
        if not (averaged(c) or rows.scatters) or (c.share <= 0.0 and not _jumps(c, rows)):
            share = min(share, c.share)
        if c.held is None or (averaged(c) and left <= 1.0 and c.held >= 0.0):
            return share
        return min(share, c.held)
    if c.kind != BESIDE:
        return 1.0
    # the channel beside states its share of the error, and what is left in units of the noise
    left = (1.0 - c.share) ** 2
    return (1.0 - left) / max(1.0 - left / max(c.chi2, 1.0), 1e-9)


def nearer(c: CandidateRow, rows: Rows) -> float:
    """Return which part of the squared error a model of the output removes, of jumps that nobody can foretell which they account for."""
    return max(c.share, _accounted(c, rows)[1]) if averaged(c) else c.share


def _accounted(c: CandidateRow, rows: Rows) -> tuple[float, float]:
    """Return what a model leaves in units of the noise, and which part of what the base leaves so it takes off."""
    left = max(c.chi2 - 1.0, 0.0)
    return left, 1.0 - left / max(rows.log.base_chi2 - 1.0, left, 1e-9)


def accounted_pct(f: Fit, rows: Rows) -> float | None:
    """Return which part (per cent) of the squared error beyond the noise a mean over jumps carries with its scatter; None of other laws."""
    row = next((c for c in rows.candidates if c.ids == f.ids), None)
    return 100.0 * carried(row, rows) if row is not None and jumping(f) else None


def averaged(c: CandidateRow) -> bool:
    """Whether a law is the mean over jumps at unknown moments."""
    return any(i in catalogue() and get(i).averaged for i in c.ids)


def _jumps(c: CandidateRow, rows: Rows) -> bool:
    """Whether a law of jumps says what the output is seen to do."""
    return averaged(c) and rows.log.rests


def only_scatters(c: CandidateRow, rows: Rows) -> bool:
    """Whether a mean over jumps that nobody sees is no nearer to the output than the base: its scatter takes up whatever there is."""
    return averaged(c) and c.share <= 0.0 and not rows.log.rests


def strained(c: CandidateRow) -> bool:
    """Whether several effects explain by sizes alone that none of them usually has: together they describe a gap and are no cause of it."""
    return c.kind == OUTPUT and len(c.ids) > 1 and c.outside >= c.strengths


def explained(rows: Rows, ids: Ids) -> str:
    """Return by what a candidate is thought to be the cause."""
    row = next(c for c in rows.candidates if c.ids == ids)
    name = " + ".join(rows.barred.get(i, i) for i in ids)
    if row.kind == RECORDER:
        return f"{name} carries {100.0 * row.share:.0f} % of the squared error beyond the noise"
    if row.kind == BESIDE:
        return f"{name} takes {100.0 * row.share:.0f} % off the error of the channel beside"
    rest = max(row.chi2 - 1.0, 0.0) * row.chi2
    return f"adding {name} gains {row.gain:.0f} nats and leaves {100.0 * np.sqrt(rest):.0f} % of the noise beyond it and what the law may be off by"


def as_large(row: CandidateRow, since: float) -> str:
    """Return what an effect would take off an error of which so large a share is new, though the model may be off by as much."""
    return (
        f"{100.0 * since:.0f} % of the squared error beyond the noise was not there when the model was accepted; "
        f"of that {' + '.join(row.ids)} would take {100.0 * row.share:.0f} %, but the model is known to be off by as much"
    )


def without_name(found: Search, rows: Rows) -> Weighed | None:
    """Return the model with what has no name that is the cause of a gap: beyond all that has one, and most of the error; None where none is."""
    own = nameless.leading(found)
    row = None if own is None else next((c for c in rows.candidates if c.ids == tuple(sorted(own.ids))), None)
    return own if row is not None and carried(row, rows) >= HALF else None


def also(rows: Rows, ids: Ids) -> str:
    """Return what has no name and explains as much as a model that is named for it, empty where nothing does; the data do not tell."""
    own = next((c.evidence for c in rows.candidates if c.ids == ids and c.kind == OUTPUT), np.inf)
    there = [c for c in rows.candidates if c.kind == OUTPUT and len(c.ids) == 1 and c.ids[0] in rows.barred]
    words = [rows.barred[c.ids[0]] for c in there if c.evidence > own - DECIDES_NATS]
    return f"{words[0]} would explain this data as well" if words else ""


def partly(rows: Rows, ids: Ids) -> str:
    """Return of how little of the gap a candidate can be the cause."""
    row = next(c for c in rows.candidates if c.ids == ids)
    return f"{' + '.join(ids)} {_little(row, carried(row, rows))}"


def _little(row: CandidateRow, share: float) -> str:
    """Return what a candidate does that carries so small a share."""
    if row.kind == BESIDE:
        return f"explains only {100.0 * share:.0f} % of what the channel beside shows beyond its noise"
    if share != row.held:
        return (
            f"explains only {100.0 * share:.0f} % of the squared error beyond the noise"
            if share > 0.0
            else "brings the model no nearer to the output"
        )
    if share <= 0.0:
        return "describes what was held out worse than nothing added"
    return f"removes {100.0 * share:.0f} % at most of the gap of what was held out"


def left(rows: Rows, top: Ids) -> str:
    """Return why even the most probable candidate is not thought to be the cause."""
    row = next((c for c in rows.candidates if c.ids == top), None)
    if row is None or not top:
        return f"something is left that no candidate explains ({rows.best.worst().name})"
    best, share = f"even the best candidate, {' + '.join(top)},", carried(row, rows)
    return f"{best} {_short_of(row, rows, share)}" + ("; the output rests and jumps where it should slide" if rows.log.rests else "")


def _short_of(row: CandidateRow, rows: Rows, share: float) -> str:
    """Return what the most probable candidate fails to do."""
    if strained(row) and share >= HALF:
        return "would need sizes that none of its effects usually has"
    if only_scatters(row, rows):
        return "lets the output scatter as it does, but its mean is no nearer to it than with nothing added"
    if share < HALF and (row.kind == BESIDE or share == row.held or share <= LEAST_SHARE):
        return _little(row, share)
    # the tests are of what the most evident model leaves, which need not be the most probable one
    worst, tested = rows.best.worst(), row.kind != OUTPUT or row is leading(rows)
    z = worst.z if tested else row.worst_z
    if z <= 2.0:
        louder = "explains it only beside noise that is larger than was measured"
        return louder if (rows.log.strain or 0.0) > 1.0 else "is less likely than something that has no name here"
    # jumps that nobody sees account for nothing
    nearer_by = min(share, row.share) if averaged(row) and not rows.log.rests else share
    by = "with jumps that nobody can foretell " if averaged(row) and nearer_by > row.share else ""
    # a share of what is no more than chance says nothing
    gap = rows.log.base_chi2 - 1.0 > 2.0 * np.sqrt(2.0 / rows.log.samples)
    says = gap and row.kind == OUTPUT and nearer_by >= HALF
    explains = f"which {by}explains {100.0 * nearer_by:.0f} % of the squared error, " if says else ""
    test, far = f"{worst.name}, " if tested else "", f"{z:.0f}" if z <= MOST_SIGMA else f"far beyond {MOST_SIGMA:g}"
    return f"{explains}leaves more than noise can be ({test}{far} sigma)"

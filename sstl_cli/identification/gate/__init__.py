"""Data that cannot be right: every rule of physics and bookkeeping that a log can break, one file a rule.

A file in ``rules/`` with ``RULE``, ``RANK`` and ``look(log)`` is found by itself. Rules are asked in the order of
their rank; a run that one of them fails is not judged by those after it, so that one slip is told once. The last ones have no
cause to name: they are silent of a run of which another rule says something. One with ``AFTER`` is silent of runs that one of these
rules has named: that explains them.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import Protocol, cast

from sstl_cli.core.aside import LISTED
from sstl_cli.core.runs import Run
from sstl_cli.identification.gate import rules
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.fingerprints import ALL, LEFT
from sstl_cli.identification.gate.measuring import MIN_SAMPLES, evidence_of
from sstl_cli.identification.gate.remark import UNNAMED, Remark
from sstl_cli.identification.gate.sensors import Sensor, sensor_of, sensors_of

__all__ = ["Evidence", "Remark", "Rule", "Sensor", "Witnesses", "catalogue", "evidence_of", "judge", "remarks", "sensor_of", "sensors_of"]

# fingerprints of all runs that are kept whole, so many of a run beyond: their memory would grow with the samples
MOST_PRINTS, PRINTS_EACH = 2**21, 4 * LEFT


class Witnesses:
    """The evidence of runs, taken one by one.

    Fingerprints are most of it. All runs of a log that has more than MOST_PRINTS of them keep the same random part.

    Of a run that is too short to be measured nothing but labels is judged, and evidence takes kilobytes: of such runs the first LISTED
    are kept, the others counted in ``short``.
    """

    def __init__(self) -> None:
        self.log: list[Evidence] = []
        self.short = 0
        self._kept = 0
        self._prints = 0
        self._below = ALL

    def add(self, run: Run, called: str = "") -> Evidence | None:
        """Take a run, perhaps ``called`` something else than its name; return what is known of it, None where it only counts."""
        if len(run) < MIN_SAMPLES:
            if self._kept == LISTED:
                self.short += 1
                return None
            self._kept += 1
        found = evidence_of(run)
        if called:
            found = replace(found, run_id=called)
        self.log.append(self._thinned(found))
        self._prints += len(self.log[-1].prints) + len(self.log[-1].output_prints)
        while self._prints > max(MOST_PRINTS, PRINTS_EACH * len(self.log)):
            self._below //= 2
            self.log = [self._thinned(e) for e in self.log]
            self._prints = sum(len(e.prints) + len(e.output_prints) for e in self.log)
        return found

    def _thinned(self, e: Evidence) -> Evidence:
        if self._below == ALL:
            return e
        return replace(e, prints=e.prints.thinned(self._below), output_prints=e.output_prints.thinned(self._below))


class Rule(Protocol):
    """One rule: its name, its place in the order, and what it says of a log."""

    RULE: str
    RANK: int

    def look(self, log: Sequence[Evidence], /) -> Iterator[Remark]:
        """Yield what is wrong with the runs of a log."""
        ...


@cache
def catalogue() -> tuple[Rule, ...]:
    """Return all rules in the order in which they are asked."""
    names = [f"{rules.__name__}.{m.name}" for m in pkgutil.iter_modules(rules.__path__)]
    found = [cast(Rule, importlib.import_module(name)) for name in names]
    return tuple(sorted(found, key=lambda rule: (rule.RANK, rule.RULE)))


def remarks(runs: Iterable[Run]) -> tuple[Remark, ...]:
    """Return what cannot be right, or hardly, in the runs of a log (or of several used together): failures first."""
    found = Witnesses()
    for run in runs:
        found.add(run)
    return judge(found.log)


def judge(log: Sequence[Evidence]) -> tuple[Remark, ...]:
    """Return the remarks on evidence that was collected run by run."""
    found: list[Remark] = []
    named: set[str] = set()
    by: dict[str, set[str]] = {}
    left = list(log)
    for rule in catalogue():
        explained = set().union(*(by.get(name, set()) for name in getattr(rule, "AFTER", ())))
        new = [r for r in rule.look([e for e in left if e.run_id not in explained]) if rule.RANK < UNNAMED or not named & set(r.run_ids)]
        found += new
        by[rule.RULE] = {name for r in new for name in r.run_ids}
        # what is said of most runs tells nothing of one of them
        named |= {name for r in new if 2 * len(r.run_ids) <= len(log) for name in r.run_ids}
        told = {name for r in new if r.failed for name in r.run_ids}
        if told:
            left = [e for e in left if e.run_id not in told]
    return tuple(sorted(found, key=lambda r: not r.failed))

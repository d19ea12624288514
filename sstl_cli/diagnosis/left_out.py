"""Runs without which the verdict differs: each that is likely to matter is left out of a diagnosis of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis import faults, gathering, odd, verdict
from sstl_cli.diagnosis.constants import CONFIRMED_RUNS, FEWEST_RUNS
from sstl_cli.diagnosis.features import CandidateRow
from sstl_cli.diagnosis.gathering import Evidence
from sstl_cli.diagnosis.question import Question
from sstl_cli.diagnosis.verdict import Verdict
from sstl_cli.physics.scenario import Scenario

# the stage, where a limit on time leaves it out
STAGE = "odd runs"


@dataclass(frozen=True)
class LeftOut:
    """A run, and the verdict on the others alone."""

    run_id: str
    verdict: Verdict


def differing(
    found: Evidence, said: Verdict, asked: Question, prior: Mapping[str, float] | None, passed: Callable[[str], bool]
) -> list[LeftOut] | None:
    """Return the runs without which the verdict differs, and what it is then; None where that was not looked at.

    Runs whose absence would make a difference to first order are left out of a diagnosis of their own.

    Parameters
    ----------
    said : Verdict
        On all runs.
    prior : mapping of id to odds, optional
        The user's odds of effects over those of the library.
    passed : callable
        Whether a stage that can be left out has to be (see core.deadline).
    """
    if len(found.problem.records) < FEWEST_RUNS or passed(STAGE):
        return None
    decide = partial(verdict.verdict, weights=asked.weights, prior=prior)
    given = asked.sim or Scenario()

    def beside(lacking: int) -> list[CandidateRow]:
        return gathering.beside(found.search, faults.beyond(found.search, given, lacking), found.beside)

    rows = odd.rows_without(found.search, found.rows, beside)
    suspects = odd.suspects(said, found.rows, [r.run_id for r in found.problem.records], rows, decide)
    confirmed: list[LeftOut] = []
    for suspect in suspects[:CONFIRMED_RUNS]:
        if passed(STAGE):
            return confirmed or None
        try:
            then = decide(gathering.gather([r for r in found.runs if r.run_id != suspect.run_id], asked, before=found).rows)
        except SstlError:
            # the others alone cannot be diagnosed
            continue
        if odd.differs(said, then):
            confirmed.append(LeftOut(suspect.run_id, then))
    return confirmed

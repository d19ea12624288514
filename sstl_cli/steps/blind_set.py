"""Make, diagnose and score the set of a withheld-effect check, which lies in a folder."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping
from concurrent.futures import as_completed
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from sstl_cli.blind import FULL_CASES, QUICK_CASES, folder, seal
from sstl_cli.blind.folder import Folder
from sstl_cli.blind.result import Result
from sstl_cli.blind.schedule import MIXED
from sstl_cli.blind.score import Set
from sstl_cli.blind.seal import Planned, Truth
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core.config import parse
from sstl_cli.core.documents.blind import BlindLimitDocument, BlindMakeDocument, BlindRunDocument, BlindScoreDocument, CaseDistance
from sstl_cli.core.errors import SstlError
from sstl_cli.core.files import write_json
from sstl_cli.core.processes import processes
from sstl_cli.core.runs import read_runs
from sstl_cli.diagnosis import weights
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import blind_limit, blind_make, blind_run, blind_score

Advance = Callable[[float], None]
LARGEST_SEED = 2**62


def _silent(_: float) -> None:
    """Tell nobody how far it is."""


@dataclass(frozen=True)
class Making:
    """Which cases to draw; without a number as many as usual, without a seed from one that nobody knows."""

    cases: int | None = None
    nulls: int = 0
    quick: bool = False
    simulator: str = MIXED
    recordings: str = MIXED
    seed: int | None = None

    @property
    def drawn(self) -> int:
        """How many cases are drawn beside the further ``nulls``."""
        usual = QUICK_CASES if self.quick else FULL_CASES
        return usual if self.cases is None else self.cases

    @property
    def count(self) -> int:
        """How many cases the set has."""
        return self.drawn + self.nulls


def make(place: Folder, asked: Making, workers: int, force: bool, advance: Advance = _silent) -> BlindMakeDocument:
    """Draw the cases of a set and write them: recordings under neutral names, the truth sealed apart.

    Raises
    ------
    SstlError
        E956 for a folder that is not empty (with ``force``: that holds no set), or if a case cannot be simulated.
    """
    seed = secrets.randbelow(LARGEST_SEED) if asked.seed is None else asked.seed
    drawn = blind_make.run(asked.drawn, seed, asked.quick, workers, advance, asked.simulator, asked.recordings, asked.nulls)
    with closing(drawn):
        return folder.write_set(place, drawn, asked.count, seed, asked.quick, force)


def diagnose(place: Folder, plan: Mapping[str, Planned], workers: int, redo: bool, advance: Advance = _silent) -> BlindRunDocument:
    """Diagnose every case that has no result yet from its recordings alone, one file a case."""
    waiting = [c for c, asked in plan.items() if redo or folder.finished(place, c, asked) is None]
    there = len(plan) - len(waiting)
    advance(there)
    (place.root / "results").mkdir(exist_ok=True)
    _work(_diagnose_one, [(str(place.root), c, plan[c]) for c in waiting], workers, advance)
    return BlindRunDocument(schema="sstl.blind.run/1", out=str(place.root), diagnosed=len(waiting), kept=there)


def limit(place: Folder, plan: Mapping[str, Planned], workers: int, redo: bool, advance: Advance = _silent) -> BlindLimitDocument:
    """Measure the distances that are not there yet, one file a case; write and return all of them as one document.

    Raises
    ------
    SstlError
        E959 while a case has no result: the truth stays closed.
    """
    lacking = [c for c, asked in plan.items() if folder.finished(place, c, asked) is None]
    if lacking:
        what = f"{len(lacking)} cases have no result: the truth stays closed"
        raise SstlError(what, where=str(place.root), fix="run 'sstl blind run' first", code="E959")
    truth = folder.open_truth(place)
    (place.root / "distances").mkdir(exist_ok=True)
    there = {} if redo else {c: row for c, asked in plan.items() if (row := folder.measured(place, c, asked)) is not None}
    advance(len(there))
    _work(_measure_one, [(str(place.root), c, plan[c], truth.truths[c]) for c in plan if c not in there], workers, advance)
    rows = [row for c, asked in plan.items() if (row := there.get(c) or folder.measured(place, c, asked)) is not None]
    document = blind_limit.document(rows, folder.published_seal(place))
    write_json(place.limit, document.plain(), force=True)
    return document


@dataclass(frozen=True)
class Opened:
    """A set whose truth was opened: what was asked, what came out, and the distances where they were measured."""

    plan: Mapping[str, Planned]
    results: Mapping[str, Result]
    truth: Truth
    of_set: Set
    distances: Mapping[str, CaseDistance] | None


def opened(place: Folder) -> Opened:
    """Return a set with its truth, once the seals are shown to hold.

    Raises
    ------
    SstlError
        E959 without any result, E952 for a broken seal, E953 and E954 for a set that the verdict was learned from.
    """
    plan = folder.read_plan(place)
    results = {c: r for c, asked in plan.items() if (r := folder.finished(place, c, asked)) is not None}
    if not results:
        raise SstlError("no case has a result", where=str(place.root), fix="run 'sstl blind run' first", code="E959")
    truth = folder.open_truth(place)
    seal.require_purpose(truth, "blind", str(place.root))
    learned_from = weights.learned().seeds
    for seeds in learned_from:
        seal.require_apart(truth.seeds, seeds, str(place.root))
    of_set = Set(seal=folder.published_seal(place), learned_from=learned_from)
    return Opened(plan, results, truth, of_set, folder.read_limit(place))


def score(place: Folder, found: Opened, realised: bool = True, advance: Advance = _silent) -> BlindScoreDocument:
    """Return how well the diagnosis did; ``realised`` applies accepted models to recordings that nobody diagnosed."""
    fresh = partial(folder.fresh_runs, place) if realised else None
    return blind_score.run(found.truth, found.plan, found.results, fresh, found.of_set, advance, found.distances)


def _work(one: Callable[[Any], None], jobs: list[Any], workers: int, advance: Advance) -> None:
    """Do jobs in processes of their own, in any order."""
    if workers <= 1 or len(jobs) <= 1:
        for job in jobs:
            one(job)
            advance(1)
        return
    with processes(workers) as pool:
        for future in as_completed([pool.submit(one, job) for job in jobs]):
            future.result()
            advance(1)


def _diagnose_one(job: tuple[str, str, Planned]) -> None:
    """Diagnose one case; this process opens the recording of the case and nothing else of the set."""
    root, case, asked = job
    place = Folder(Path(root))
    folder.check_log(place, case, asked)
    sim = parse(Scenario, asked.sim, f"plan, {case}")
    with threadpool_limits(1):
        result = blind_run.run(case, list(read_runs(place.log(case))), sim, asked.exclude)
    folder.keep_result(place, case, result, asked)


def _measure_one(job: tuple[str, str, Planned, CaseTruth]) -> None:
    """Measure the distances of one case."""
    root, case, asked, truth = job
    place = Folder(Path(root))
    folder.check_log(place, case, asked)
    sim = parse(Scenario, asked.sim, f"plan, {case}")
    with threadpool_limits(1):
        found = blind_limit.run(case, truth, sim, asked.exclude)
    folder.keep_distance(place, found, asked)

"""Make a library to learn the verdict's weights from: draw cases, gather their evidence, keep the rows."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import as_completed
from contextlib import closing, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

from sstl_cli.blind import sessions
from sstl_cli.blind.cases import Case
from sstl_cli.blind.learning import Example
from sstl_cli.blind.library import LIBRARY, case_name, labelled, to_table, without, write_library
from sstl_cli.blind.schedule import MIXED, Job, jobs
from sstl_cli.blind.sessions import Sessions
from sstl_cli.blind.strength import STRENGTHS
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core.documents.blind import BlindLibraryDocument
from sstl_cli.core.errors import SstlError
from sstl_cli.core.files import read_json, require_writable, write_json
from sstl_cli.core.parquet import open_table
from sstl_cli.core.processes import processes
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run
from sstl_cli.steps.blind_make import draw_job

if TYPE_CHECKING:
    from sstl_cli.diagnosis.question import Question

PLAN = "sstl.blind.library.plan/1"
COMMAND = "sstl blind library"
# combinations of more effects are no answer of any case
MOST_EFFECTS = 2
Gatherer = Callable[[Job], Sequence[Example]]


@dataclass(frozen=True)
class Options:
    """Which cases are drawn: how many, from which seed on, by which simulators, how long, as recorded how, how strong.

    ``accepted`` cases ask what has changed since a session of which the model was accepted, those with ``habits`` are of rigs that do
    what no law describes.
    """

    cases: int
    seed: int
    simulator: str
    quick: bool = False
    recordings: str = MIXED
    strengths: tuple[float, ...] = STRENGTHS
    accepted: bool = False
    habits: bool = False


def run(
    out: Path,
    asked: Options,
    workers: int = 1,
    force: bool = False,
    advance: Callable[[float], None] = lambda _: None,
    gatherer: Gatherer | None = None,
) -> BlindLibraryDocument:
    """Write a library; an interrupted run goes on where it stopped, from the parts in ``OUT.parts``.

    Parameters
    ----------
    gatherer : callable, optional
        Returns the rows of one case (and of the same without its effect); by default it is drawn and searched.

    Raises
    ------
    SstlError
        If the file exists without ``force``, or its parts belong to another library.
    """
    require_writable(out, force)
    parts = out.with_name(f"{out.name}.parts")
    drawn = jobs(asked.cases, asked.seed, asked.simulator, asked.quick, asked.recordings, asked.strengths)
    waiting = [replace(j, accepted=asked.accepted, habits=asked.habits) for j in drawn]
    _claim(parts, {**asdict(asked), "strengths": list(asked.strengths)})
    left = [j for j in waiting if not _part(parts, j).exists()]
    advance(len(waiting) - len(left))
    with closing(_worked(left, parts, workers, gatherer or gather)) as done:
        for _ in done:
            advance(1)
    return _collected(out, parts, waiting, asked, force)


def _collected(out: Path, parts: Path, waiting: Sequence[Job], asked: Options, force: bool) -> BlindLibraryDocument:
    """Write the parts as one table and take them away; return how it was made."""
    tables = [open_table(_part(parts, j), LIBRARY).table() for j in waiting]
    failed = sum(t.num_rows == 0 for t in tables)
    table = pa.concat_tables(tables)
    made = BlindLibraryDocument(
        schema="sstl.blind.library/1",
        out=str(out),
        cases=asked.cases - failed,
        failed=failed,
        simulators=sorted({j.simulator for j in waiting}),
        seeds=[[asked.seed, asked.seed + asked.cases - 1]],
        quick=asked.quick,
        recordings=asked.recordings,
        strengths=list(asked.strengths),
        accepted=asked.accepted,
        habits=asked.habits,
        rows=table.num_rows,
    )
    facts = made.model_dump(exclude={"schema_id", "out", "rows"})
    write_library(out, table, Provenance(COMMAND, asked.seed, {}, facts), force)
    # what else somebody has put there stays
    for own in (parts / "plan.json", *(_part(parts, j) for j in waiting), *parts.glob(".*.tmp")):
        own.unlink(missing_ok=True)
    with suppress(OSError):
        parts.rmdir()
    return made


def gather(job: Job) -> list[Example]:
    """Return the rows of one case, searched as ``sstl diagnose`` does, with ``--sim`` where a model was accepted before.

    Where it could be told that its effect is missing they come a second time, searched without that effect: what no candidate
    explains the noise takes up in part, which nobody sees who only takes the effect out of the evidence.
    """
    from threadpoolctl import threadpool_limits

    from sstl_cli.steps.diagnose import DiagnoseOptions
    from sstl_cli.steps.diagnose import run as diagnose

    np.seterr(all="ignore")
    case: Case | Sessions = sessions.draw(job) if job.accepted else sessions.with_habit(job) if job.habits else draw_job(job)
    runs, before = (case.after, case.before) if isinstance(case, Sessions) else (case.runs, [])
    position = any(r.position_in_mm is not None for r in runs)
    options = DiagnoseOptions(sim=case.sim, exclude=case.exclude, position=position, max_effects=MOST_EFFECTS)
    with threadpool_limits(1):
        if before:
            options = replace(options, sim=diagnose(before, options).model())
        return [*_searched(case_name(job), case.truth, runs, options, again=not job.habits)]


def _searched(name: str, truth: CaseTruth, runs: Sequence[Run], options: Question, again: bool) -> Generator[Example]:
    from sstl_cli.diagnosis.gathering import gather as evidence

    found = labelled(name, truth, evidence(runs, options).rows.named)
    yield found
    missing = without(found) if again else None
    if missing is not None:
        less = replace(options, exclude=tuple(sorted({*options.exclude, *found.answer})))
        yield replace(missing, rows=evidence(runs, less).rows.named)


def _claim(parts: Path, asked: Mapping[str, object]) -> None:
    """Make the folder of parts, or see that those in it answer the same question."""
    plan = parts / "plan.json"
    if parts.exists():
        found = read_json(plan, PLAN)
        if {k: found.get(k) for k in asked} != dict(asked):
            raise SstlError("holds the parts of another library", where=str(parts), fix="remove it, or give its options again", code="E956")
        return
    parts.mkdir(parents=True)
    write_json(plan, {"schema": PLAN, **asked})


def _part(parts: Path, job: Job) -> Path:
    return parts / f"{case_name(job)}.parquet"


def _worked(waiting: list[Job], parts: Path, workers: int, gatherer: Gatherer) -> Generator[None]:
    if workers <= 1 or len(waiting) <= 1:
        for job in waiting:
            _one(job, parts, gatherer)
            yield
        return
    with processes(workers) as pool:
        for future in as_completed([pool.submit(_one, job, parts, gatherer) for job in waiting]):
            future.result()
            yield


def _one(job: Job, parts: Path, gatherer: Gatherer) -> None:
    """Write the part of one case; one that cannot be drawn or searched is an empty part, counted as failed."""
    try:
        found = gatherer(job)
    except SstlError:
        found = []
    made = Provenance(COMMAND, job.seed, {}, {"simulator": job.simulator, "quick": job.quick, "as_labs": job.as_labs, **asdict(job.entry)})
    write_library(_part(parts, job), to_table(found), made, force=True)

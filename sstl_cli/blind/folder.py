"""The folder of a withheld-effect check: what lies where, and who may open it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sstl_cli.core.processes import processes

if TYPE_CHECKING:
    from sstl_cli.blind.cases import Case
    from sstl_cli.blind.result import Result
    from sstl_cli.blind.seal import Planned, Truth
    from sstl_cli.blind.truth import CaseTruth
    from sstl_cli.core.documents.blind import BlindLimitDocument, BlindMakeDocument, CaseDistance
    from sstl_cli.core.runs import Run


PARTS = ("cases", "fresh", "results", "distances")
# what the file of one distance has beside it
BESIDE = ("schema", "log_sha256")


@dataclass(frozen=True)
class Folder:
    """Paths of a set; ``truth`` is opened by scoring and by the limit only, ``fresh`` by scoring only."""

    root: Path

    @property
    def hashes(self) -> Path:
        return self.root / "hashes.json"

    @property
    def plan(self) -> Path:
        return self.root / "plan.json"

    @property
    def truth(self) -> Path:
        return self.root / "truth.json"

    @property
    def limit(self) -> Path:
        return self.root / "limit.json"

    def files(self) -> Iterator[Path]:
        """Yield every file of the set that is there."""
        yield from (p for p in (self.hashes, self.plan, self.truth, self.limit) if p.is_file())
        for part in PARTS:
            yield from (self.root / part).glob("*.*")

    def distance(self, case: str) -> Path:
        return self.root / "distances" / f"{case}.json"

    def log(self, case: str) -> Path:
        return self.root / "cases" / f"{case}.parquet"

    def fresh(self, case: str) -> Path:
        return self.root / "fresh" / f"{case}.parquet"

    def result(self, case: str) -> Path:
        return self.root / "results" / f"{case}.json"


def write_set(folder: Folder, cases: Iterator[tuple[str, Case]], count: int, seed: int, quick: bool, force: bool) -> BlindMakeDocument:
    """Write a set: hashes first, then the recordings and the plan; the truth goes into its one file last."""
    from sstl_cli.blind import seal
    from sstl_cli.core.documents.blind import BlindMakeDocument
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import require_followed, write_json
    from sstl_cli.core.provenance import Provenance, sha256
    from sstl_cli.core.runs import write_runs

    root = folder.root
    require_followed(root)
    old: list[Path] = []
    if root.exists() and (not root.is_dir() or any(root.iterdir())):
        if not root.is_dir():
            raise SstlError("is not a folder", where=str(root), fix="give a folder", code="E956")
        if not force:
            raise SstlError("exists already and is not empty", where=str(root), fix="give a new folder, or --force", code="E956")
        old = _old_set(folder)
    root.mkdir(parents=True, exist_ok=True)
    # the same words for every case: nothing of how it was made
    provenance = Provenance("sstl blind make", None, {})
    hidden = root / ".unfinished"
    shutil.rmtree(hidden, ignore_errors=True)
    truths: dict[str, CaseTruth] = {}
    rows: list[dict[str, object]] = []
    samples = 0
    try:
        for part in ("cases", "fresh"):
            (hidden / part).mkdir(parents=True)
        for name, case in cases:
            path = hidden / "cases" / f"{name}.parquet"
            samples += write_runs(path, case.runs, provenance)
            if case.fresh:
                write_runs(hidden / "fresh" / f"{name}.parquet", case.fresh, provenance)
            truths[name] = case.truth
            sim = case.sim.model_dump(mode="json", by_alias=True, exclude_none=True)
            rows.append({"case": name, "sha256": sha256(path), "exclude": list(case.exclude), "sim": sim})
        published, closed = seal.seal(truths, "blind", [seed, seed + count - 1], quick)
        _remove(folder, old)
        write_json(folder.hashes, published)
        for part in ("cases", "fresh"):
            (hidden / part).rename(root / part)
        write_json(folder.plan, {"schema": seal.PLAN, "purpose": "blind", "cases": rows})
        write_json(folder.truth, closed)
    finally:
        shutil.rmtree(hidden, ignore_errors=True)
    return BlindMakeDocument(
        schema="sstl.blind.make/1", out=str(root), quick=quick, cases=len(truths), samples=samples, seal=str(published["set"])
    )


def _old_set(folder: Folder) -> list[Path]:
    """Return the files of the set that a new one may replace.

    Raises
    ------
    SstlError
        E956 where the folder holds no set, or a file that is none of the set's where the set keeps its own.
    """
    from sstl_cli.blind import seal
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import read_json

    try:
        sealed = read_json(folder.hashes, seal.HASHES)["cases"]
    except (SstlError, KeyError):
        fix = "give a new folder: --force replaces sets only"
        raise SstlError("exists already and holds no set", where=str(folder.root), fix=fix, code="E956") from None
    own = [folder.hashes, folder.plan, folder.truth, folder.limit]
    own += [place(case) for case in sealed if _plain(case) for place in (folder.log, folder.fresh, folder.result, folder.distance)]
    found = [p for p in own if p.is_file()]
    for part in PARTS:
        # what a killed call left behind is the set's too
        there = [p for p in (folder.root / part).glob("*") if not (p.name.startswith(".") and p.name.endswith(".tmp"))]
        if foreign := next((p for p in there if p not in found), None):
            raise SstlError("is no file of the set, and would be lost", where=str(foreign), fix="move it away", code="E956")
        found += [p for p in (folder.root / part).glob(".*.tmp") if p.is_file()]
    return found


def _remove(folder: Folder, files: list[Path]) -> None:
    """Remove the files of an old set, and the folders that are empty then."""
    for path in files:
        path.unlink(missing_ok=True)
    for part in PARTS if files else ():
        if (folder.root / part).is_dir():
            (folder.root / part).rmdir()


def read_plan(folder: Folder) -> dict[str, Planned]:
    """Return what is asked of each case, by name."""
    from sstl_cli.blind import seal
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import read_json

    rows = read_json(folder.plan, seal.PLAN)["cases"]
    if strange := next((row["case"] for row in rows if not _plain(row["case"])), None):
        raise SstlError(f"{strange!r} is no name of a case", where=str(folder.plan), fix="make the set again", code="E952")
    return {row["case"]: seal.Planned.of(row) for row in rows}


def _plain(case: object) -> bool:
    """Whether the name of a case is that of a file inside the set, whoever made it."""
    return isinstance(case, str) and case not in ("", ".", "..") and not {"/", "\\", "\0"} & set(case)


def open_truth(folder: Folder) -> Truth:
    """Return the truth once it is shown to be the one that was sealed."""
    from sstl_cli.blind import seal
    from sstl_cli.core.files import read_json

    published, closed = read_json(folder.hashes, seal.HASHES), read_json(folder.truth, seal.TRUTH)
    return seal.verify(published, closed, str(folder.truth))


def published_seal(folder: Folder) -> str:
    """Return the published seal of the whole set."""
    from sstl_cli.blind import seal
    from sstl_cli.core.files import read_json

    return str(read_json(folder.hashes, seal.HASHES)["set"])


def check_log(folder: Folder, case: str, asked: Planned) -> None:
    """Raise SstlError unless the recording of a case is the one that was planned."""
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.provenance import sha256

    path = folder.log(case)
    if not path.is_file():
        raise SstlError("recording is missing", where=str(path), fix="make the set again", code="E952")
    if sha256(path) != asked.sha256:
        raise SstlError("recording differs from the planned one", where=str(path), fix="make the set again", code="E952")


def finished(folder: Folder, case: str, asked: Planned) -> Result | None:
    """Return the result of a case if it is there and answers this recording and these options."""
    from sstl_cli.blind.result import Result
    from sstl_cli.core.config import parse
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import read_json
    from sstl_cli.steps.blind_run import SCHEMA

    if not folder.result(case).exists():
        return None
    try:
        result = parse(Result, read_json(folder.result(case), SCHEMA), case)
    except SstlError:
        return None
    same = result.log_sha256 == asked.sha256 and result.exclude == list(asked.exclude)
    return result if same else None


def fresh_runs(folder: Folder, case: str) -> list[Run]:
    """Return the recordings of a case that nobody diagnosed (none for poor excitation)."""
    from sstl_cli.core.runs import read_runs

    path = folder.fresh(case)
    return list(read_runs(path)) if path.is_file() else []


def diagnose_all(
    folder: Folder, plan: Mapping[str, Planned], workers: int, redo: bool, advance: Callable[[float], None]
) -> tuple[int, int]:
    """Diagnose what has no result yet, one file a case; return how many were done and how many were there."""
    waiting = [c for c, asked in plan.items() if redo or finished(folder, c, asked) is None]
    there = len(plan) - len(waiting)
    advance(there)
    (folder.root / "results").mkdir(exist_ok=True)
    _work(_diagnose_one, [(str(folder.root), c, plan[c]) for c in waiting], workers, advance)
    return len(waiting), there


def _work(one: Callable[[Any], None], jobs: list[Any], workers: int, advance: Callable[[float], None]) -> None:
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
    from threadpoolctl import threadpool_limits

    from sstl_cli.core.config import parse
    from sstl_cli.core.files import write_json
    from sstl_cli.core.runs import read_runs
    from sstl_cli.physics.scenario import Scenario
    from sstl_cli.steps import blind_run

    root, case, asked = job
    folder = Folder(Path(root))
    check_log(folder, case, asked)
    sim = parse(Scenario, asked.sim, f"plan, {case}")
    with threadpool_limits(1):
        result = blind_run.run(case, list(read_runs(folder.log(case))), sim, asked.exclude)
    result = {**result, "log_sha256": asked.sha256, "exclude": list(asked.exclude)}
    write_json(folder.result(case), result, force=True)


def read_limit(folder: Folder) -> dict[str, CaseDistance] | None:
    """Return the distances of a set by case, None where nobody has measured them.

    Raises
    ------
    SstlError
        If they belong to another set.
    """
    from sstl_cli.core.documents.blind import CaseDistance
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import read_json
    from sstl_cli.steps.blind_limit import SCHEMA

    if not folder.limit.exists():
        return None
    found = read_json(folder.limit, SCHEMA)
    if found.get("seal") != published_seal(folder):
        raise SstlError("was measured on another set", where=str(folder.limit), fix="run 'sstl blind limit' again", code="E952")
    return {row["case"]: CaseDistance(**row) for row in found["distances"]}


def measure_all(
    folder: Folder, plan: Mapping[str, Planned], truth: Truth, workers: int, redo: bool, advance: Callable[[float], None]
) -> BlindLimitDocument:
    """Measure the distances that are not there yet, one file a case; write and return all of them as one document."""
    from sstl_cli.core.documents.blind import CaseDistance
    from sstl_cli.core.files import read_json, write_json
    from sstl_cli.steps import blind_limit

    (folder.root / "distances").mkdir(exist_ok=True)
    waiting = [c for c, asked in plan.items() if redo or not _measured(folder, c, asked)]
    advance(len(plan) - len(waiting))
    jobs = [(str(folder.root), c, plan[c], truth.truths[c]) for c in waiting]
    _work(_measure_one, jobs, workers, advance)
    found = (read_json(folder.distance(c), blind_limit.CASE) for c in plan)
    rows = [CaseDistance(**{k: v for k, v in row.items() if k not in BESIDE}) for row in found]
    document = blind_limit.document(rows, published_seal(folder))
    write_json(folder.limit, document.plain(), force=True)
    return document


def _measured(folder: Folder, case: str, asked: Planned) -> bool:
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import read_json
    from sstl_cli.steps.blind_limit import CASE

    try:
        return folder.distance(case).exists() and read_json(folder.distance(case), CASE)["log_sha256"] == asked.sha256
    except SstlError:
        return False


def _measure_one(job: tuple[str, str, Planned, CaseTruth]) -> None:
    """Measure the distances of one case."""
    from threadpoolctl import threadpool_limits

    from sstl_cli.core.config import parse
    from sstl_cli.core.files import write_json
    from sstl_cli.physics.scenario import Scenario
    from sstl_cli.steps import blind_limit

    root, case, asked, truth = job
    folder = Folder(Path(root))
    check_log(folder, case, asked)
    sim = parse(Scenario, asked.sim, f"plan, {case}")
    with threadpool_limits(1):
        found = blind_limit.run(case, truth, sim, asked.exclude)
    write_json(folder.distance(case), {"schema": blind_limit.CASE, **found.plain(), "log_sha256": asked.sha256}, force=True)

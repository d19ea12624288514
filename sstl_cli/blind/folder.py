"""The folder of a withheld-effect check: what lies where, and who may open it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from sstl_cli.blind import seal
from sstl_cli.blind.cases import Case
from sstl_cli.blind.result import SCHEMA, Result
from sstl_cli.blind.seal import Planned, Truth
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core import files
from sstl_cli.core.config import parse
from sstl_cli.core.documents.blind import BlindMakeDocument, CaseDistance
from sstl_cli.core.errors import SstlError
from sstl_cli.core.files import read_json
from sstl_cli.core.provenance import Provenance, sha256
from sstl_cli.core.runs import Run, read_runs, write_runs

LIMIT, DISTANCE = "sstl.blind.limit/1", "sstl.blind.limit.case/1"
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
    root = folder.root
    files.require_followed(root)
    old: list[Path] = []
    if root.exists() and (not root.is_dir() or any(root.iterdir())):
        if not root.is_dir():
            raise SstlError("is not a folder", where=str(root), fix="give a folder", code="E956")
        if not force:
            raise SstlError("exists already and is not empty", where=str(root), fix="give a new folder, or --force", code="E956")
        old = _old_set(folder)
    made = [place for place in (root, *root.parents) if not place.exists()]
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
        files.write_json(folder.hashes, published)
        for part in ("cases", "fresh"):
            (hidden / part).rename(root / part)
        files.write_json(folder.plan, {"schema": seal.PLAN, "purpose": "blind", "cases": rows})
        files.write_json(folder.truth, closed)
    finally:
        shutil.rmtree(hidden, ignore_errors=True)
        for place in made:
            if not any(place.iterdir()):
                place.rmdir()
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
    rows = read_json(folder.plan, seal.PLAN)["cases"]
    if strange := next((row["case"] for row in rows if not _plain(row["case"])), None):
        raise SstlError(f"{strange!r} is no name of a case", where=str(folder.plan), fix="make the set again", code="E952")
    return {row["case"]: seal.Planned.of(row) for row in rows}


def _plain(case: object) -> bool:
    """Whether the name of a case is that of a file inside the set, whoever made it."""
    return isinstance(case, str) and case not in ("", ".", "..") and not {"/", "\\", "\0"} & set(case)


def open_truth(folder: Folder) -> Truth:
    """Return the truth once it is shown to be the one that was sealed."""
    published, closed = read_json(folder.hashes, seal.HASHES), read_json(folder.truth, seal.TRUTH)
    return seal.verify(published, closed, str(folder.truth))


def published_seal(folder: Folder) -> str:
    """Return the published seal of the whole set."""
    return str(read_json(folder.hashes, seal.HASHES)["set"])


def check_log(folder: Folder, case: str, asked: Planned) -> None:
    """Raise SstlError unless the recording of a case is the one that was planned."""
    path = folder.log(case)
    if not path.is_file():
        raise SstlError("recording is missing", where=str(path), fix="make the set again", code="E952")
    if sha256(path) != asked.sha256:
        raise SstlError("recording differs from the planned one", where=str(path), fix="make the set again", code="E952")


def finished(folder: Folder, case: str, asked: Planned) -> Result | None:
    """Return the result of a case if it is there and answers this recording and these options."""
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
    path = folder.fresh(case)
    return list(read_runs(path)) if path.is_file() else []


def read_limit(folder: Folder) -> dict[str, CaseDistance] | None:
    """Return the distances of a set by case, None where nobody has measured them.

    Raises
    ------
    SstlError
        If they belong to another set.
    """
    if not folder.limit.exists():
        return None
    found = read_json(folder.limit, LIMIT)
    if found.get("seal") != published_seal(folder):
        raise SstlError("was measured on another set", where=str(folder.limit), fix="run 'sstl blind limit' again", code="E952")
    return {row["case"]: CaseDistance(**row) for row in found["distances"]}


def measured(folder: Folder, case: str, asked: Planned) -> CaseDistance | None:
    """Return the distances of a case if they are there and belong to this recording."""
    try:
        told = read_json(folder.distance(case), DISTANCE) if folder.distance(case).exists() else None
    except SstlError:
        return None
    if told is None or told["log_sha256"] != asked.sha256:
        return None
    return CaseDistance(**{k: v for k, v in told.items() if k not in BESIDE})


def keep_distance(folder: Folder, found: CaseDistance, asked: Planned) -> None:
    """Write the distances of a case, with the recording that they belong to."""
    files.write_json(folder.distance(found.case), {"schema": DISTANCE, **found.plain(), "log_sha256": asked.sha256}, force=True)


def keep_result(folder: Folder, case: str, result: Mapping[str, object], asked: Planned) -> None:
    """Write the result of a case, with the recording and the options that it answers."""
    files.write_json(folder.result(case), {**result, "log_sha256": asked.sha256, "exclude": list(asked.exclude)}, force=True)

"""The files of one call as recordings: labels from names and a manifest, files appended or side by side."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path, PurePosixPath

from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.core.files import require_regular
from sstl_cli.importers.finder import Recording
from sstl_cli.importers.mapping import LABELS, Mapping
from sstl_cli.importers.pattern import search
from sstl_cli.importers.plan import Plan, plan_of, recordings
from sstl_cli.importers.rows import JoinedRows

MAX_MANIFEST_BYTES = 16 << 20
Labels = dict[str, str | float]


@dataclass(frozen=True)
class Group:
    """One recording: a plan, or several plans whose samples follow one another."""

    plans: tuple[Plan, ...]
    name: str

    @property
    def where(self) -> str:
        """File concerned, for messages."""
        return str(self.plans[0].files[0].path)


@dataclass(frozen=True)
class Bad:
    """A file of a batch that cannot be imported, and why."""

    path: Path
    error: SstlError


def groups(files: list[Path], mapping: Mapping, wanted: str | None, manifest: dict[str, Labels]) -> Iterator[Group | Bad]:
    """Yield the recordings of a call in the order of the files; a file that cannot be opened comes as ``Bad``."""
    if mapping.files.merge == "no":
        for path in files:
            try:
                yield from list(_of_file(path, mapping, wanted, manifest))
            except SstlError as error:
                yield Bad(path, error)
        return
    names = {path: labels_of(path, mapping, manifest) for path in files}
    keyed: dict[str, list[Path]] = {}
    for path in files:
        keyed.setdefault(_key(path, mapping, names[path]), []).append(path)
    for key, paths in keyed.items():
        labels = {k: v for p in paths for k, v in names[p].items()}
        try:
            yield _merged(paths, mapping, wanted, labels, str(labels.get("run_id", key)))
        except SstlError as error:
            yield Bad(paths[0], error)


def _of_file(path: Path, mapping: Mapping, wanted: str | None, manifest: dict[str, Labels]) -> Iterator[Group]:
    names = labels_of(path, mapping, manifest)
    for recording in recordings(path, mapping, wanted):
        part = _part_name(recording)
        labels = {**names, **_part_labels(recording, mapping)}
        # a variable may be called after its file
        name = f"{stem(path)}-{part}" if part and part != re.sub(r"[^\w.+-]+", "-", stem(path)) else stem(path)
        if "runs" in recording.prefix and part and mapping.runs is None:
            name = part
        yield Group((plan_of([recording], mapping, labels, str(labels.get("run_id", name))),), name)


def _merged(paths: list[Path], mapping: Mapping, wanted: str | None, labels: Labels, name: str) -> Group:
    parts = [_single(p, mapping, wanted) for p in paths]
    if mapping.files.merge == "rows":
        joined = JoinedRows(tuple(parts))
        layout = parts[0].layout
        parts = [Recording(paths[0], joined, tuple(joined.channels(paths[0], layout)), layout)]
    if mapping.files.merge == "append":
        return Group(tuple(plan_of([r], mapping, labels, name) for r in parts), name)
    return Group((plan_of(parts, mapping, labels, name),), name)


def stem(path: Path) -> str:
    """Return the name of a file without its extension."""
    return path.stem or path.name


def labels_of(path: Path, mapping: Mapping, manifest: dict[str, Labels]) -> Labels:
    """Return what the file's name (by pattern) and the manifest say about it.

    Raises
    ------
    SstlError
        If the name does not fit the pattern, or the manifest does not list the file.
    """
    labels: Labels = {"stem": stem(path), "file": path.name, "folder": path.absolute().parent.name}
    if mapping.file_name is not None:
        [found] = search(mapping.file_name, [path.name])
        if found is None:
            raise SstlError(
                f"name does not fit the pattern '{mapping.file_name}'", where=str(path), fix="correct file_name in the mapping", code="E341"
            )
        labels |= found
    if manifest:
        labels |= manifest[_listed(path, list(manifest))]
    return labels


def _listed(path: Path, rows: list[str]) -> str:
    """Return the row of a manifest for a file: of those for files of its name the one whose folders are its own, as far as they are written.

    Examples
    --------
    >>> _listed(Path("/data/bend60/act.csv"), ["bend30/act.csv", "bend60/act.csv"])
    'bend60/act.csv'
    """
    named = [r for r in rows if PurePosixPath(r).name == path.name]
    if not named:
        raise SstlError("is not listed in the manifest", where=str(path), fix=nearest(path.name, rows), code="E342")
    own = path.absolute().parts[::-1]
    shared = {r: sum(1 for _ in takewhile(lambda p: p[0] == p[1], zip(PurePosixPath(r).parts[::-1], own, strict=False))) for r in named}
    best = [r for r in named if shared[r] == max(shared.values())]
    if len(best) > 1:
        what = f"may be either of the manifest's rows {', '.join(best[:4])}"
        raise SstlError(what, where=str(path), fix="write the folders of each into the column 'file', as in bend30/act.csv", code="E342")
    return best[0]


def read_manifest(path: Path) -> dict[str, Labels]:
    """Return ``{file name: labels}`` from a CSV with a column ``file`` and one column a label."""
    require_regular(path)
    try:
        if path.stat().st_size > MAX_MANIFEST_BYTES:
            raise SstlError("is larger than 16 MiB", where=str(path), fix="give a manifest table", code="E343")
        with open(path, encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file)
            heads = list(reader.fieldnames or ())
            rows = list(reader)
    except OSError as error:
        raise SstlError(f"cannot be read: {error.strerror}", where=str(path), code="E343") from None
    except (ValueError, csv.Error) as error:
        raise SstlError(f"is not a CSV table ({str(error)[:80]})", where=str(path), code="E343") from None
    twice = [n for n in heads if heads.count(n) > 1]
    if twice:
        raise SstlError(f"has column '{twice[0]}' more than once", where=str(path), fix="drop all but one", code="E343")
    names = list(rows[0]) if rows else []
    if "file" not in names:
        raise SstlError("has no column 'file'", where=str(path), fix=f"columns: file and any of {', '.join(LABELS)}", code="E343")
    out: dict[str, Labels] = {}
    for row in rows:
        if None in row or None in row.values():
            raise SstlError(
                f"row of '{row['file']}' has another number of columns",
                where=str(path),
                fix="give every row a value for each column",
                code="E343",
            )
        file_name = row["file"].strip().replace("\\", "/")
        if file_name in out:
            what = f"lists '{file_name}' more than once"
            raise SstlError(what, where=str(path), fix="give each file one row, with its folder where names are the same", code="E343")
        out[file_name] = {k.strip(): v.strip() for k, v in row.items() if k != "file" and v.strip()}
    return out


def _key(path: Path, mapping: Mapping, labels: Labels) -> str:
    if mapping.files.key is None:
        return str(labels.get("run_id", "merged"))
    if mapping.files.key not in labels:
        raise SstlError(
            f"has no '{mapping.files.key}' to merge by",
            where=str(path),
            fix="give file_name a group of that name, or a manifest column",
            code="E344",
        )
    return str(labels[mapping.files.key])


def _single(path: Path, mapping: Mapping, wanted: str | None) -> Recording:
    found = recordings(path, mapping, wanted)
    if len(found) > 1:
        raise SstlError("holds several runs and cannot be merged", where=str(path), fix="import it by itself", code="E344")
    return found[0]


def _part_name(recording: Recording) -> str:
    return re.sub(r"[^\w.+-]+", "-", recording.prefix).strip("-.") if recording.prefix else ""


def _part_labels(recording: Recording, mapping: Mapping) -> Labels:
    if not recording.prefix or mapping.runs is None:
        return {}
    [found] = search(f"\\A(?:{mapping.runs})", [recording.prefix])
    return dict(found or {})

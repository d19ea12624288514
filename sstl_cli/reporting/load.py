"""Recognise the toolchain's outputs by what they say they are, and read them for a report."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from sstl_cli.core.aside import Aside
from sstl_cli.core.documents.control import ScoreRow
from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.files import read_json, require_regular
from sstl_cli.core.parquet import open_table, schema_id_of
from sstl_cli.core.provenance import sha256
from sstl_cli.core.runs import Run, few_short, read_runs
from sstl_cli.core.sound import note, why_no_lines
from sstl_cli.core.tables import COMMAND, EVALUATION, LOG, PHASES, SCHEMAS, SCORE, THETA
from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.documents import read
from sstl_cli.reporting.inputs import PHASE_CODES, Inputs, Model, command_view, segments, view
from sstl_cli.reporting.rows import Evaluated, epochs, predictions
from sstl_cli.reporting.scored import Scored

MAX_HEADER_BYTES = 16 << 20
TABLES = {
    LOG.id: "log",
    THETA.id: "theta",
    PHASES.id: "phases",
    COMMAND.id: "command",
    SCORE.id: "score",
    EVALUATION.id: "evaluation",
    "sstl.history": "history",
    "sstl.predictions": "predictions",
    "sstl.prediction": "predictions",
}
DOCUMENTS = {"sstl.diagnosis": "diagnosis", "sstl.diagnose": "diagnosis", "sstl.blind.score": "blind", "sstl.evaluate": "evaluate"}
KINDS = sorted({*TABLES.values(), *DOCUMENTS.values(), "model", "document"})


def kind_of(path: Path) -> str:
    """Return what a file holds: one of KINDS.

    Raises
    ------
    SstlError
        E601 for a file that is none of the toolchain's outputs, E602 for a table of an unknown schema.
    """
    path = Path(path)
    require_regular(path)
    try:
        with open(path, "rb") as file:
            head = file.read(16)
    except OSError as error:
        raise SstlError(f"cannot be read: {error.strerror}", where=str(path), fix="check path and rights", code="E601") from None
    if head.startswith(b"PAR1"):
        return _table_kind(path)
    if path.suffix == ".safetensors":
        return "model"
    if head.lstrip()[:1] == b"{":
        return _document_kind(read_json(path), path)
    raise SstlError(
        "is not an output of sstl",
        where=str(path),
        fix="give Parquet tables, JSON documents or a .safetensors model; bring other logs in with sstl import",
        code="E601",
    )


def load(paths: list[Path]) -> Inputs:
    """Return every file read, sorted by kind and name, so that the order of arguments does not matter.

    Raises
    ------
    UsageError
        E607 if a file is given twice.
    SstlError
        E601 to E604 for files that are not what they should be.
    """
    paths = [Path(p) for p in paths]
    if len({p.resolve() for p in paths}) != len(paths):
        raise UsageError("a file is given twice", where="FILE", fix="name each file once", code="E607")
    inputs = Inputs()
    found = sorted((kind_of(p), p.name, str(p)) for p in paths)
    for kind, name, path in found:
        _READERS[kind](Path(path), inputs)
        inputs.files.append((kind, name, sha256(path)))
    return inputs


def _table_kind(path: Path) -> str:
    found = schema_id_of(path)
    if found in TABLES:
        return TABLES[found]
    if found is None:
        # tables written by other programs carry no schema id: their columns tell, the widest schema first
        names = pq.ParquetFile(path).schema_arrow.names
        for schema in sorted(SCHEMAS.values(), key=lambda s: -len(s.required)):
            if set(schema.required) <= set(names):
                return TABLES[schema.id]
    raise SstlError(
        f"holds the unknown table {found!r}" if found else "has the columns of no known table",
        where=str(path),
        fix=f"known: {', '.join(sorted(TABLES))}",
        code="E602",
    )


def _document_kind(document: Any, path: Path) -> str:
    schema = str(document.get("schema", ""))
    name = schema.split("/")[0]
    if name in DOCUMENTS:
        return DOCUMENTS[name]
    if name.startswith("sstl."):
        return "document"
    raise SstlError('has no "schema" of sstl', where=str(path), fix="give a document written with --json", code="E603")


def _log(path: Path, inputs: Inputs) -> None:
    def left(_: Run) -> None:
        inputs.left_out[path.name] = inputs.left_out.get(path.name, 0) + 1

    inputs.log.extend(view(run) for run in few_short(read_runs(path), left) if len(run))


def _read(path: Path, schema: Any = None) -> list[dict[str, Any]]:
    """Return the rows of a table as they stand in the file."""
    found: list[dict[str, Any]] = (
        open_table(path, schema).table() if schema else pq.read_table(path, page_checksum_verification=True)
    ).to_pylist()
    return found


def _score(path: Path, inputs: Inputs) -> None:
    inputs.score.extend(ScoreRow.model_construct(**{c.name: row[c.name] for c in SCORE.columns}) for row in _read(path, SCORE))


def _evaluation(path: Path, inputs: Inputs) -> None:
    rows = ({c.name: row[c.name] for c in EVALUATION.columns} for row in _read(path, EVALUATION))
    inputs.evaluation.extend(Evaluated(**row, file=str(path)) for row in rows)


def _history(path: Path, inputs: Inputs) -> None:
    inputs.history.extend(epochs(_read(path), str(path)))


def _predictions(path: Path, inputs: Inputs) -> None:
    inputs.predictions.extend(predictions(_read(path)))


def _theta(path: Path, inputs: Inputs) -> None:
    """Read rows of Theta; values that no loop can have are taken as null and noted."""
    for row in _read(path, THETA):
        wrong = why_no_lines(row)
        if wrong:
            said = ", ".join(f"{name} {why}" for name, why in wrong.items())
            note([Aside(str(row["run_id"]), 0, 1, f"{said}, taken as null")])
        # the table was checked against its schema already
        inputs.theta.append(ThetaRow.model_construct(**{**row, **dict.fromkeys(wrong)}))


def _diagnosis(path: Path, inputs: Inputs) -> None:
    inputs.diagnosis.append(read(Diagnosed, {**read_json(path), "file": path.name}))


def _blind(path: Path, inputs: Inputs) -> None:
    inputs.blind.append(read(Scored, {**read_json(path), "file": path.name}))


def _evaluate(path: Path, inputs: Inputs) -> None:
    inputs.evaluate.append((path.name, read_json(path)))


def _other(path: Path, inputs: Inputs) -> None:
    inputs.document.append((path.name, read_json(path)))


def _phases(path: Path, inputs: Inputs) -> None:
    for run_id, piece in _groups(path, PHASES, ["run_id"]):
        inputs.phases[run_id[0]] = segments(piece.column("time_s").to_numpy(), _codes(piece))


def _command(path: Path, inputs: Inputs) -> None:
    names = ("time_s", "tension_ref_n", "tension_out_n")
    for (run_id, method), piece in _groups(path, COMMAND, ["run_id", "method"]):
        columns = {n: piece.column(n).to_numpy() for n in names}
        inputs.command.append(command_view(run_id, method, columns, _codes(piece)))


def _groups(path: Path, schema: Any, keys: list[str]) -> Iterator[tuple[tuple[str, ...], pa.Table]]:
    """Yield contiguous rows with equal keys; memory is bounded by the largest group."""
    pending: list[pa.Table] = []
    current: tuple[str, ...] | None = None
    for block in open_table(path, schema).blocks():
        codes = [np.asarray(block.column(k).combine_chunks().dictionary_encode().indices) for k in keys]
        change = np.zeros(max(block.num_rows - 1, 0), dtype=bool)
        for code in codes:
            change |= np.diff(code) != 0
        edges = np.concatenate(([0], np.flatnonzero(change) + 1, [block.num_rows]))
        for a, b in pairwise(edges):
            if a == b:
                continue
            piece = block.slice(int(a), int(b - a))
            key = tuple(str(piece.column(k)[0].as_py()) for k in keys)
            if current is not None and key != current:
                yield current, pa.concat_tables(pending)
                pending = []
            current = key
            pending.append(piece)
    if current is not None:
        yield current, pa.concat_tables(pending)


def _codes(table: pa.Table) -> NDArray[np.int8]:
    place = {name: i for i, name in enumerate(PHASE_CODES)}
    encoded = table.column("phase").combine_chunks().dictionary_encode()
    known = np.array([place.get(v, -1) for v in encoded.dictionary.to_pylist()] or [-1], dtype=np.int8)
    codes: NDArray[np.int8] = known[encoded.indices.fill_null(0).to_numpy(zero_copy_only=False)]
    return codes


def _model(path: Path, inputs: Inputs) -> None:
    """Read the header alone: eight bytes of length, then JSON; the weights stay on disk."""
    with open(path, "rb") as file:
        start = file.read(8)
        length = struct.unpack("<Q", start)[0] if len(start) == 8 else 0
        raw = file.read(length) if 0 < length <= MAX_HEADER_BYTES else b""
    try:
        header = json.loads(raw)
        metadata = {str(k): str(v) for k, v in header.pop("__metadata__", {}).items()}
        tensors = sorted((str(k), str(v["dtype"]), [int(n) for n in v["shape"]]) for k, v in header.items())
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise SstlError("is not a readable safetensors model", where=str(path), fix="train it again", code="E605") from None
    inputs.model.append(Model(path.name, dict(sorted(metadata.items())), tensors))


_READERS: dict[str, Callable[[Path, Inputs], None]] = {
    "log": _log,
    "phases": _phases,
    "command": _command,
    "model": _model,
    "document": _other,
    "theta": _theta,
    "score": _score,
    "evaluation": _evaluation,
    "history": _history,
    "predictions": _predictions,
    "diagnosis": _diagnosis,
    "blind": _blind,
    "evaluate": _evaluate,
}

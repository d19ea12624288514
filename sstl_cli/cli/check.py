"""``sstl check``: everything that is wrong with a table, not only the first thing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sstl_cli.cli.options import Config, Json, NoPhysics
from sstl_cli.cli.render import Screen, many

if TYPE_CHECKING:
    from sstl_cli.steps.check import Finding, Piece

EPILOG = "Example: sstl check log.parquet theta.parquet"
# findings of one kind that are listed one by one
LISTED = 50
SHOWN = 40


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("check", epilog=EPILOG)(check)


def check(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG", help="Files of sstl: logs and other tables, logs as CSV, JSON, models.")],
    no_physics: NoPhysics = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Check tables: schema, units, sampling, gaps, time order, NaN, saturation, quantisation, flat or frozen channels.

    Logs are judged by physics too, and refresh period, step and noise of their channels are listed. Every failure is
    told. Exit code 1 if there is any; remarks alone are fine.
    """
    from sstl_cli.cli import _physics

    screen = Screen(as_json)
    entries: list[dict[str, Any]] = []
    for path in logs:
        entries += [{"file": str(path), **e} for e in _check_file(path, screen)]
    judged = _physics.judge([] if no_physics else logs, screen)
    rows = [
        (
            e["level"],
            Path(e["file"]).name,
            e["run_id"] or "",
            e["column"] or "",
            f"{e['what']}: {e['detail']}",
            e["fix"],
        )
        for e in sorted(entries, key=lambda e: e["level"])
    ]
    entries += _physics.findings(judged)
    failures = [e for e in entries if e["level"] == "failure"]
    remarks = len(entries) - len(failures)
    which = f"{logs[0].name} is" if len(logs) == 1 else "Some are" if failures else "All are"
    screen.say(f"{which} {'not sound' if failures else 'sound'}. {many(len(logs), 'file')}: {many(len(failures), 'failure')}, {many(remarks, 'remark')}")
    _physics.show(screen, judged.remarks)
    if rows:
        # where a file or a column is the same in all rows it need not be said in each
        keep = [i for i in range(6) if i in (0, 4, 5) or len({r[i] for r in rows}) > 1 or (i > 1 and rows[0][i])]
        header = ("level", "file", "run", "column", "what", "do")
        screen.table("", [header[i] for i in keep], [[r[i] for i in keep] for r in rows], most=SHOWN)
    _physics.show_channels(screen, judged)
    document = {
        "schema": "sstl.check/1",
        "ok": not failures,
        "failures": len(failures),
        "remarks": remarks,
        "findings": entries,
        "physics": _physics.document(judged.remarks),
        "sensors": _physics.channels(judged),
        "files": [str(p) for p in logs],
    }
    screen.finish(document, 1 if failures else 0)


def _entry(finding: Finding, run_id: str | None = None) -> dict[str, Any]:
    from dataclasses import asdict

    return {"run_id": run_id, **asdict(finding)}


def _check_file(path: Path, screen: Screen) -> Iterator[dict[str, Any]]:
    from sstl_cli.cli._text_table import TextTable
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.kinds import kind_of
    from sstl_cli.core.parquet import open_table, schema_id_of
    from sstl_cli.core.tables import LOG, SCHEMAS, Schema
    from sstl_cli.steps.check import FAILURE, REMARK, Finding

    kind = kind_of(path) if path.is_file() else ""
    if kind in ("json", "safetensors"):
        from sstl_cli.cli._other_files import findings as of_others

        yield from map(_entry, of_others(path, kind))
        return
    try:
        name = LOG.id if kind == "text" else schema_id_of(path)
        schema = SCHEMAS.get(name or LOG.id)
        if schema is None:
            yield _entry(Finding(FAILURE, "unknown table", "", 1, repr(name), "give a table made by sstl"))
            return
        # no columns demanded here: each missing one becomes a finding of its own
        reader: Any = TextTable(path) if kind == "text" else open_table(path, Schema(schema.id, schema.version, ()))
    except SstlError as error:
        yield _entry(Finding(FAILURE, "unreadable", "", 1, error.what, error.fix))
        return
    if name is None:
        yield _entry(Finding(REMARK, "no provenance", "", 1, "no schema in the file; read as a log", "none needed"))
    yield from map(_entry, _schema_findings(reader.file.schema_arrow, schema))
    if reader.rows == 0:
        yield _entry(Finding(FAILURE, "no rows", "", 0, "the table is empty", "record or import again"))
        return
    numeric = [c.name for c in schema.columns if _is_float(reader.file.schema_arrow, c.name)]
    try:
        if schema is not LOG:
            required = [n for n in schema.required if n in numeric]
            yield from _check_table(reader, numeric, required)
            return
        yield from _few(_check_log(reader, numeric, screen))
    except SstlError as error:
        yield _entry(Finding(FAILURE, "unreadable", "", 1, error.what, error.fix))


def _check_log(reader: Any, numeric: list[str], screen: Screen) -> Iterator[dict[str, Any]]:
    """Yield the findings on every run, its rows brought together first where they lie apart."""
    from sstl_cli.core.tables import LOG
    from sstl_cli.steps import check as step
    from sstl_cli.steps.check import FAILURE, Finding

    optional = tuple(n for n in numeric if n not in LOG.required)
    stretches = _stretches(reader)
    apart = {run_id: n for run_id, n in stretches.items() if n > 1}
    blocks = _blocks(reader)
    if apart:
        runs = f"run {next(iter(apart))!r} comes" if len(apart) == 1 else f"{len(apart)} of {len(stretches)} runs come"
        detail = f"{runs} in {sum(apart.values())} pieces" + ("; is the log sorted by time?" if len(apart) > 1 else "")
        finding = Finding(FAILURE, "runs in pieces", "run_id", len(apart), detail, "sort by run_id, then by time_s")
        yield _entry(finding, next(iter(apart)) if len(apart) == 1 else None)
        blocks = iter([_by_run(blocks)])
    with screen.progress("checking", reader.rows) as advance:
        for piece in _pieces(blocks, numeric):
            yield from (_entry(f, piece.run_id) for f in step.run(piece, optional))
            advance(len(next(iter(piece.columns.values()), ())))


def _few(entries: Iterator[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the first entries of every kind, then one that counts the others of it."""
    kinds: dict[tuple[str, ...], list[int]] = {}
    for entry in entries:
        kind = tuple(str(entry[k]) for k in ("level", "what", "column", "fix"))
        seen = kinds.setdefault(kind, [0, 0])
        seen[0] += 1
        if seen[0] <= LISTED:
            yield entry
        else:
            seen[1] += int(entry["count"])
    for (level, what, column, fix), (n, count) in kinds.items():
        if n > LISTED:
            more = {"level": level, "what": what, "column": column, "count": count, "fix": fix}
            yield {"run_id": None, **more, "detail": f"in {n - LISTED} more runs"}


def _stretches(reader: Any) -> dict[str | None, int]:
    """Return in how many stretches of rows each run comes, in order of appearance."""
    import pyarrow as pa
    import pyarrow.compute as pc

    found: dict[str | None, int] = {}
    last: Any = ()
    for block in _blocks(reader, ["run_id"]) if "run_id" in reader.file.schema_arrow.names else ():
        ids = block.column("run_id").cast(pa.string()).combine_chunks()
        ids = ids.combine_chunks() if isinstance(ids, pa.ChunkedArray) else ids
        for run_id in pc.run_end_encode(ids).values.to_pylist():
            if run_id != last:
                found[run_id] = found.get(run_id, 0) + 1
            last = run_id
    return found


def _by_run(blocks: Iterator[Any]) -> Any:
    """Return all blocks as one table whose runs are contiguous, in order of appearance, their rows in file order."""
    import numpy as np
    import pyarrow as pa

    table = pa.concat_tables(list(blocks), promote_options="permissive")
    codes = table.column("run_id").cast(pa.string()).combine_chunks().dictionary_encode()
    codes = codes.combine_chunks() if isinstance(codes, pa.ChunkedArray) else codes
    return table.take(pa.array(np.argsort(codes.indices.fill_null(-1).to_numpy(zero_copy_only=False), kind="stable")))


def _is_float(arrow: Any, name: str) -> bool:
    import pyarrow as pa

    return name in arrow.names and (
        pa.types.is_floating(arrow.field(name).type) or pa.types.is_integer(arrow.field(name).type)
    )


def _schema_findings(arrow: Any, schema: Any) -> Iterator[Finding]:
    """Yield missing columns, columns of a wrong type, and units that are absent or not ours."""
    import pyarrow as pa

    from sstl_cli.core.errors import nearest
    from sstl_cli.core.units import is_force
    from sstl_cli.steps.check import FAILURE, REMARK, Finding

    spare = [n for n in arrow.names if n not in schema.names]
    for column in schema.columns:
        if column.name not in arrow.names:
            if not column.nullable:
                hint = nearest(column.name, spare) if spare else "rename it or import with a mapping"
                yield Finding(FAILURE, "missing column", column.name, 1, "not in the file", hint)
            continue
        field = arrow.field(column.name)
        text = (pa.types.is_string, pa.types.is_large_string, pa.types.is_dictionary, pa.types.is_null)
        number = (pa.types.is_floating, pa.types.is_integer, pa.types.is_null)
        fits = any(test(field.type) for test in (text if column.type == pa.string() else number))
        if not fits:
            yield Finding(
                FAILURE, "wrong type", column.name, 1, f"{field.type}, not {column.type}", f"write it as {column.type}"
            )
        unit = (field.metadata or {}).get(b"unit")
        if unit is None and column.unit:
            yield Finding(
                REMARK, "no unit stated", column.name, 1, f"taken as {column.unit}", "none needed if that is right"
            )
        elif unit is not None and unit.decode(errors="replace") != column.unit:
            stated = unit.decode(errors="replace")
            if column.name in ("tension_in_n", "tension_out_n") and not is_force(stated):
                detail = f"in {stated}, declared in the mapping: slopes and biases are in this unit too"
                yield Finding(REMARK, "not a tension", column.name, 1, detail, "none needed")
                continue
            detail = f"{stated!r}, not {column.unit!r}"
            yield Finding(FAILURE, "wrong unit", column.name, 1, detail, "convert it with sstl import")


def _blocks(reader: Any, columns: list[str] | None = None) -> Iterator[Any]:
    import pyarrow as pa

    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.parquet import ROWS_PER_BLOCK

    try:
        for batch in reader.file.iter_batches(ROWS_PER_BLOCK, columns=columns):
            yield pa.Table.from_batches([batch])
    except (pa.ArrowException, OSError) as error:
        raise SstlError(
            f"damaged ({str(error)[:100]})", where=str(reader.path), fix="make the file again", code="E230"
        ) from None


def _check_table(reader: Any, numeric: list[str], required: list[str]) -> Iterator[dict[str, Any]]:
    from sstl_cli.core.tables import THETA
    from sstl_cli.steps import check as step
    from sstl_cli.steps.check import FAILURE, REMARK, Finding

    ids: dict[str, int] = {}
    for block in _blocks(reader):
        nulls = {n: block.column(n).null_count for n in block.column_names}
        columns = {n: _numbers(block.column(n)) for n in numeric}
        yield from map(_entry, step.table(columns, nulls, required))
        if "status" in block.column_names and reader.metadata.get("schema") == THETA.id:
            for run_id, status in zip(
                block.column("run_id").to_pylist(), block.column("status").to_pylist(), strict=True
            ):
                ids[str(run_id)] = ids.get(str(run_id), 0) + 1
                if status != "ok":
                    yield _entry(Finding(REMARK, "set aside", "status", 1, str(status), "none needed"), run_id)
    for run_id, count in ids.items():
        if count > 1:
            yield _entry(
                Finding(FAILURE, "run comes twice", "run_id", count, f"{count} rows", "keep one row a run"), run_id
            )


def _numbers(column: Any) -> Any:
    import pyarrow as pa

    return (
        column.cast(pa.float64()).to_numpy(zero_copy_only=False)
        if not pa.types.is_null(column.type)
        else column.to_numpy()
    )


def _pieces(blocks: Iterator[Any], numeric: list[str]) -> Iterator[Piece]:
    """Yield contiguous stretches of one run_id; memory is bounded by the longest."""
    import numpy as np
    import pyarrow as pa

    pending: Any = None
    for block in blocks:
        starts = [0]
        if "run_id" in block.column_names:
            ids = block.column("run_id").cast(pa.string()).combine_chunks()
            codes = ids.dictionary_encode()
            codes = codes.combine_chunks() if isinstance(codes, pa.ChunkedArray) else codes
            changed = np.flatnonzero(np.diff(codes.indices.fill_null(-1).to_numpy(zero_copy_only=False)))
            starts += (changed + 1).tolist()
        for a, b in zip(starts, [*starts[1:], block.num_rows], strict=True):
            piece = block.slice(a, b - a)
            if pending is not None and _run_of(pending) == _run_of(piece):
                pending = pa.concat_tables([pending, piece])
                continue
            if pending is not None:
                yield _piece(pending, numeric)
            pending = piece
    if pending is not None:
        yield _piece(pending, numeric)


def _run_of(table: Any) -> Any:
    return table.column("run_id")[0].as_py() if "run_id" in table.column_names else None


def _piece(table: Any, numeric: list[str]) -> Piece:
    from sstl_cli.steps.check import Piece

    labels = [n for n in ("config_id", "system", "location", "trajectory") if n in table.column_names]
    signals = [n for n in numeric if n != "lead_mm"]
    run_id = _run_of(table)
    return Piece(
        None if run_id is None else str(run_id),
        {n: _numbers(table.column(n)) for n in signals},
        {n: table.column(n).unique().to_pylist() for n in labels},
        {n: table.column(n).null_count for n in signals},
    )

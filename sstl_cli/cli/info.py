"""``sstl info``: what a file holds, run by run, and where it came from."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sstl_cli.cli.options import Config, Json
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.steps.info import RunSummary

EPILOG = "Example: sstl info log.parquet"
SHOWN = 20
LOOP_POINTS = 3000


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("info", epilog=EPILOG)(info)


def info(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Files of sstl: tables, logs as CSV, JSON, models.")],
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Summarise tables, documents and models: runs, samples, rates, ranges, provenance, and a small picture of the first loop."""
    screen = Screen(as_json)
    documents = [_describe(path, screen) for path in files]
    screen.finish({"schema": "sstl.info/1", "files": documents})


def _describe(path: Path, screen: Screen) -> dict[str, Any]:
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.kinds import kind_of
    from sstl_cli.core.parquet import open_table, schema_id_of
    from sstl_cli.core.tables import LOG, SCHEMAS

    kind = kind_of(path) if path.is_file() else ""
    if kind in ("json", "safetensors"):
        from sstl_cli.cli._other_files import describe

        return describe(path, kind, screen)
    name = LOG.id if kind == "text" else schema_id_of(path)
    schema = SCHEMAS.get(name or LOG.id)
    if schema is None:
        raise SstlError(
            f"holds {name!r}, which this program does not know",
            where=str(path),
            fix="give a table of sstl",
            code="E240",
        )
    reader: Any = _text(path) if kind == "text" else open_table(path, schema)
    origin = reader.metadata
    screen.say(
        f"{path.name} is a table {schema.id} (version {schema.version}) of {reader.rows} rows, {path.stat().st_size / 1e6:.2f} MB."
    )
    if origin:
        screen.say(f"  made by: {origin.get('command')}")
        screen.line(f"  sstl {origin.get('package_version')}, seed {origin.get('seed')}")
        inputs = origin.get("inputs")
        for source, digest in inputs.items() if isinstance(inputs, dict) else ():
            screen.line(f"  from {source} (sha256 {str(digest)[:12]})")
    else:
        screen.line("  no provenance in the file")
    document = {
        "file": str(path),
        "schema": schema.id,
        "version": schema.version,
        "rows": reader.rows,
        "provenance": origin or None,
        "columns": reader.file.schema_arrow.names,
    }
    if schema is LOG:
        return {**document, "runs": _log(reader, screen)}
    return {**document, "ranges": _other(reader, screen)}


def _text(path: Path) -> Any:
    from sstl_cli.cli._text_table import TextTable
    from sstl_cli.core.parquet import check_columns
    from sstl_cli.core.tables import LOG

    table = TextTable(path)
    check_columns(table.schema_arrow.names, LOG, str(path))
    return table


def _log(reader: Any, screen: Screen) -> list[dict[str, Any]]:
    from dataclasses import asdict

    from sstl_cli.core.runs import units_of
    from sstl_cli.steps import info as step

    lost = _Lost()
    runs = step.run([s for table in _tables(reader) for s in _summaries(table, lost)])
    screen.aside.entries += lost.entries(runs)
    rows = [
        (
            r.run_id,
            r.config_id,
            r.system,
            r.samples,
            round(r.end_s - r.start_s, 1),
            r.rate_hz,
            _span(r.in_min_n, r.in_max_n),
            _span(r.out_min_n, r.out_max_n),
        )
        for r in runs
    ]
    units = units_of(reader.file.schema_arrow)
    header = ("run", "config", "system", "rows", "s", "Hz", f"T_in {units['unit_in']}", f"T_out {units['unit_out']}")
    screen.table(f"{len(runs)} runs", header, rows, most=SHOWN)
    if not screen.as_json and runs:
        for line in _loop(reader, runs[0], units["unit_in"], units["unit_out"]):
            screen.line(line)
    return [{**asdict(r), "duration_s": r.end_s - r.start_s, "rate_hz": r.rate_hz} for r in runs]


def _span(low: float, high: float) -> str:
    """Return a range to about a hundredth of its width, so that the names beside it have room.

    Examples
    --------
    >>> _span(-0.0612, 30.049), _span(0.0, 0.25)
    ('-0.1..30.0', '0.000..0.250')
    """
    width = high - low
    digits = max(0, 2 - math.floor(math.log10(width))) if 0 < width < math.inf else 2
    return f"{round(low, digits) + 0.0:.{digits}f}..{round(high, digits) + 0.0:.{digits}f}"


COLUMNS = ("run_id", "config_id", "system", "location", "time_s", "tension_in_n", "tension_out_n")


def _tables(reader: Any) -> Iterator[Any]:
    import pyarrow as pa

    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.parquet import ROWS_PER_BLOCK, conform
    from sstl_cli.core.tables import LOG, Schema

    # only what is shown is read; empty values are for sstl check to judge
    wanted = Schema(LOG.id, LOG.version, tuple(_relaxed(c) for c in LOG.columns if c.name in COLUMNS))
    present = [n for n in COLUMNS if n in reader.file.schema_arrow.names]
    try:
        for batch in reader.file.iter_batches(ROWS_PER_BLOCK, columns=present):
            yield conform(pa.Table.from_batches([batch]), wanted, str(reader.path))
    except (pa.ArrowException, OSError) as error:
        raise SstlError(
            f"is damaged ({str(error)[:120]})", where=str(reader.path), fix="make the file again", code="E241"
        ) from None


def _relaxed(column: Any) -> Any:
    from dataclasses import replace

    return replace(column, nullable=True)


class _Lost:
    """Values that no recorder can have given, counted by run and reason; the ranges shown leave them out."""

    def __init__(self) -> None:
        self.by_run: dict[str, dict[str, int]] = {}

    def ranges(self, name: str, column: Any, starts: Any, run_ids: list[str]) -> tuple[list[float], list[float]]:
        """Return the smallest and largest sound value of each stretch of rows (NaN where it has none), and count the others.

        Parameters
        ----------
        column : Arrow chunked array, shape (n,)
            The values; empty ones are for sstl check to judge.
        starts : ndarray of int, shape (m,)
            First row of each stretch.
        run_ids : list of str
            The run of each stretch.
        """
        import numpy as np
        import pyarrow.compute as pc

        from sstl_cli.core.sound import unsound, why_unsound

        null = pc.is_null(column)
        empty = _numpy(pc.cast(null, "uint8")).astype(bool)
        # any number does in the place of an empty value: a Python one would import pandas
        values = _numpy(pc.coalesce(pc.cast(column, "double"), pc.cast(pc.cast(null, "uint8"), "double"))).astype(np.float64)
        wrong = unsound(values)
        with_faults = np.logical_or.reduceat(wrong, starts)
        out = wrong | empty
        ends = [*starts.tolist()[1:], len(values)]
        for i in np.flatnonzero(with_faults).tolist():
            rows = slice(starts[i], ends[i])
            counts = self.by_run.setdefault(run_ids[i], {})
            for why, n in why_unsound(name, values[rows][~empty[rows]]).items():
                counts[f"{why} in {name}"] = counts.get(f"{why} in {name}", 0) + n
        low = np.minimum.reduceat(np.where(out, np.inf, values), starts)
        high = np.maximum.reduceat(np.where(out, -np.inf, values), starts)
        none = low > high
        return np.where(none, np.nan, low).tolist(), np.where(none, np.nan, high).tolist()

    def entries(self, runs: list[RunSummary]) -> Iterator[Any]:
        """Yield what was left out, one entry a run and reason, and runs that no sensor can have given."""
        import numpy as np

        from sstl_cli.core.aside import Aside
        from sstl_cli.core.sound import too_small

        for run in runs:
            for why, n in self.by_run.get(run.run_id, {}).items():
                yield Aside(run.run_id, n, run.samples, why)
            ranges = {"tension_in_n": (run.in_min_n, run.in_max_n), "tension_out_n": (run.out_min_n, run.out_max_n)}
            for name, ends in ranges.items():
                if said := too_small(name, np.array(ends)):
                    yield Aside(run.run_id, run.samples, run.samples, said)


def _summaries(table: Any, lost: _Lost) -> Iterator[RunSummary]:
    """Yield a summary of each stretch of one run_id (Arrow's own grouping would import pandas)."""
    import numpy as np
    import pyarrow as pa
    import pyarrow.compute as pc

    from sstl_cli.steps.info import RunSummary

    ids = table.column("run_id").combine_chunks()
    ids = ids.combine_chunks() if isinstance(ids, pa.ChunkedArray) else ids
    ends = pc.run_end_encode(ids).run_ends.to_pylist()
    if not ends:
        return
    starts = np.array([0, *ends[:-1]])
    # an Arrow array made of a list would import pandas
    rows = np.diff([0, *ends]).tolist()
    labels = [[table.column(n)[i].as_py() for i in starts.tolist()] for n in ("run_id", "system", "config_id", "location")]
    run_ids = [str(v) for v in labels[0]]
    limits = [v for name in COLUMNS[-3:] for v in lost.ranges(name, table.column(name), starts, run_ids)]
    for run_id, system, config_id, location, n, *six in zip(run_ids, *labels[1:], rows, *limits, strict=True):
        yield RunSummary(run_id, system, config_id, location, n, *six)


def _numpy(column: Any) -> Any:
    """Return an Arrow column without nulls as an array; Arrow's own way there would import pandas."""
    import numpy as np
    import pyarrow as pa

    held = column.combine_chunks()
    return np.from_dlpack(held if isinstance(held, pa.Array) else pa.concat_arrays(held.chunks))


def _loop(reader: Any, first: RunSummary, unit_in: str, unit_out: str) -> list[str]:
    """Return the drawing of the first run's loop, read from as many row groups as it needs."""
    import pyarrow.compute as pc

    from sstl_cli.steps.info import draw_loop

    stride = max(1, first.samples // LOOP_POINTS)
    x: list[float] = []
    y: list[float] = []
    left = first.samples
    run_id: Any = None
    for table in _tables(reader):
        # an Arrow scalar: converting a Python string would import pandas
        run_id = table.column("run_id")[0] if run_id is None else run_id
        mine = table.filter(pc.equal(table.column("run_id"), run_id))
        left -= len(mine)
        x += mine.column("tension_in_n").to_pylist()[::stride]
        y += mine.column("tension_out_n").to_pylist()[::stride]
        if left <= 0:
            break
    drawn = draw_loop(x, y)
    if not drawn:
        return []
    lines = [f"loop of {first.run_id}: T_out over T_in"]
    for i, row in enumerate(drawn):
        label = (
            f"{first.out_max_n:8.3g} {unit_out} "
            if i == 0
            else f"{first.out_min_n:8.3g} {unit_out} "
            if i == len(drawn) - 1
            else " " * (10 + len(unit_out))
        )
        lines.append(label + row)
    low, high = f"{first.in_min_n:.3g} {unit_in}", f"{first.in_max_n:.3g} {unit_in}"
    return [*lines, " " * (10 + len(unit_out)) + low + high.rjust(len(drawn[0]) - len(low))]


def _other(reader: Any, screen: Screen) -> dict[str, Any]:
    """Return count, minimum, mean and maximum of each number column, and counts of each label."""
    import pyarrow as pa
    import pyarrow.compute as pc

    table = reader.table()
    ranges: dict[str, Any] = {}
    rows = []
    for name in table.column_names:
        column = table.column(name)
        if pa.types.is_floating(column.type) or pa.types.is_integer(column.type):
            ends = pc.min_max(column).as_py()
            ranges[name] = {
                "nulls": column.null_count,
                "min": ends["min"],
                "mean": pc.mean(column).as_py(),
                "max": ends["max"],
            }
            unit = (
                (reader.schema.arrow().field(name).metadata or {}).get(b"unit", b"").decode()
                if name in reader.schema.names
                else ""
            )
            rows.append((name, "" if unit == "1" else unit, column.null_count, ends["min"], ranges[name]["mean"], ends["max"]))
        else:
            counts = pc.value_counts(column).to_pylist()
            ranges[name] = {"nulls": column.null_count, "distinct": len(counts)}
            if name in ("status", "phase", "method", "variant", "window"):
                ranges[name]["counts"] = {str(c["values"]): c["counts"] for c in counts}
                screen.say(f"  {name}: " + ", ".join(f"{c['values']} {c['counts']}" for c in counts[:8]))
    screen.table("", ("column", "unit", "nulls", "min", "mean", "max"), rows)
    return ranges

"""``sstl info``: what a file holds, run by run, and where it came from."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sstl_cli.cli.options import Config, Json
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.core.documents.logs import ColumnRange, FileInfo
    from sstl_cli.steps.info import RunSummary

EPILOG = "Example: sstl info log.parquet"
SHOWN = 20


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
    from sstl_cli.core.documents.logs import InfoDocument

    screen.finish(InfoDocument(schema="sstl.info/1", files=[_describe(path, screen) for path in files]))


def _describe(path: Path, screen: Screen) -> FileInfo:
    from sstl_cli.cli._other_files import describe, other_kind
    from sstl_cli.core.documents.logs import FileInfo
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.kinds import kind_of
    from sstl_cli.core.parquet import open_table, schema_id_of
    from sstl_cli.core.tables import LOG, SCHEMAS

    if other := other_kind(path):
        return describe(path, other, screen)
    kind = kind_of(path) if path.is_file() else ""
    name = LOG.id if kind == "text" else schema_id_of(path)
    schema = SCHEMAS.get(name or LOG.id)
    if schema is None:
        raise SstlError(f"holds {name!r}, which this program does not know", where=str(path), fix="give a table of sstl", code="E240")
    reader: Any = _text(path) if kind == "text" else open_table(path, schema)
    origin = reader.metadata
    screen.say(f"{path.name} is a table {schema.id} (version {schema.version}) of {reader.rows} rows, {path.stat().st_size / 1e6:.2f} MB.")
    if origin:
        screen.say(f"  made by: {origin.get('command')}")
        screen.line(f"  sstl {origin.get('package_version')}, seed {origin.get('seed')}")
        inputs = origin.get("inputs")
        for source, digest in inputs.items() if isinstance(inputs, dict) else ():
            screen.line(f"  from {source} (sha256 {str(digest)[:12]})")
        extra = origin.get("extra")
        values = extra.get("environment") if isinstance(extra, dict) else None
        for name, value in values.items() if isinstance(values, dict) else ():
            screen.line(f"  with {name}={value}")
    else:
        screen.line("  no provenance in the file")
    held = FileInfo(
        file=str(path),
        schema=schema.id,
        version=schema.version,
        rows=reader.rows,
        provenance=origin or None,
        columns=reader.file.schema_arrow.names,
    )
    return held.model_copy(update=_log(reader, screen) if schema is LOG else {"ranges": _other(reader, screen)})


def _text(path: Path) -> Any:
    from sstl_cli.core.parquet import check_columns
    from sstl_cli.core.tables import LOG
    from sstl_cli.importers.text_table import TextTable

    table = TextTable(path)
    check_columns(table.schema_arrow.names, LOG, str(path))
    return table


def _log(reader: Any, screen: Screen) -> dict[str, object]:
    """Print the runs of a log, and return what its document says of them."""
    from sstl_cli.core.runs import units_of
    from sstl_cli.steps import info_table as step

    runs, aside = step.runs_of(reader)
    screen.aside.add(aside)
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
        for r in runs[:SHOWN]
    ]
    told, left_out = step.told(runs)
    units = units_of(reader.file.schema_arrow)
    header = ("run", "config", "system", "rows", "s", "Hz", f"T_in {units['unit_in']}", f"T_out {units['unit_out']}")
    screen.table(
        f"{len(runs)} runs", header, rows, more=len(runs) - len(rows), whole="--json" if not left_out else "--json, very short ones aside,"
    )
    if not screen.as_json and runs:
        for line in _loop(step.loop_of(reader, runs[0]), runs[0], units["unit_in"], units["unit_out"]):
            screen.line(line)
    if not screen.as_json:
        # they are made where they are shown; of a million runs they take gigabytes
        return {"runs": []}
    return {"runs": [r.document() for r in told], **({"runs_left_out": left_out} if left_out else {})}


def _span(low: float, high: float) -> str:
    """Return a range to about a hundredth of its width, so that the names beside it have room.

    Examples
    --------
    >>> _span(-0.0612, 30.049), _span(0.0, 0.25)
    ('-0.1..30.0', '0.000..0.250')
    >>> _span(2e-310, 1e-309), _span(math.nan, math.nan)
    ('2e-310..1e-309', '-')
    """
    width = high - low
    if math.isnan(width):
        return "-"
    if 0 < width < 1e-6:
        return f"{low:.3g}..{high:.3g}"
    digits = max(0, 2 - math.floor(math.log10(width))) if 0 < width < math.inf else 2
    return f"{round(low, digits) + 0.0:.{digits}f}..{round(high, digits) + 0.0:.{digits}f}"


def _loop(drawn: list[str], first: RunSummary, unit_in: str, unit_out: str) -> list[str]:
    """Return a drawn loop between the ends of its axes."""
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


def _other(reader: Any, screen: Screen) -> dict[str, ColumnRange]:
    """Return the ranges of every column, and print them."""
    from sstl_cli.steps.info_table import ranges_of

    ranges = ranges_of(reader.table())
    rows = []
    for name, found in ranges.items():
        if found.distinct is None:
            rows.append((name, _unit(reader, name), found.nulls, found.min, found.mean, found.max))
        elif found.counts is not None:
            screen.say(f"  {name}: " + ", ".join(f"{value} {n}" for value, n in list(found.counts.items())[:8]))
    screen.table("", ("column", "unit", "nulls", "min", "mean", "max"), rows)
    return ranges


def _unit(reader: Any, name: str) -> str:
    """Return the unit of a column of the schema, empty for a plain number."""
    metadata = reader.schema.arrow().field(name).metadata if name in reader.schema.names else None
    unit = (metadata or {}).get(b"unit", b"").decode()
    return "" if unit == "1" else unit

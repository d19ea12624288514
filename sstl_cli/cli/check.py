"""``sstl check``: everything that is wrong with a table, not only the first thing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sstl_cli.cli.options import Config, Json, NoPhysics
from sstl_cli.cli.render import Screen, many

if TYPE_CHECKING:
    from sstl_cli.steps.check import Entry

EPILOG = "Example: sstl check log.parquet theta.parquet"
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
    from sstl_cli.core.documents.logs import CheckDocument
    from sstl_cli.steps.judge import findings

    screen = Screen(as_json)
    entries = [e.of(str(path)) for path in logs for e in _entries(path, screen)]
    judged = _physics.judge([] if no_physics else logs, screen)
    rows = [
        (e.level, Path(e.file).name, e.run_id or "", e.column or "", f"{e.what}: {e.detail}", e.fix)
        for e in sorted(entries, key=lambda e: e.level)
    ]
    # the headline counts what is said below it: a sentence on many runs is one
    levels = [r.severity for r in judged.remarks] + [e.level for e in entries]
    told = {level: levels.count(level) for level in ("failure", "remark")}
    entries += findings(judged)
    failures = [e for e in entries if e.level == "failure"]
    remarks = len(entries) - len(failures)
    screen.say(
        f"{_headline(logs, bool(failures), told['remark'] > 0)}. {many(len(logs), 'file')}: "
        f"{many(told['failure'], 'failure')}, {many(told['remark'], 'remark')}"
    )
    _physics.show(screen, judged.remarks)
    if rows:
        # where a file or a column is the same in all rows it need not be said in each
        keep = [i for i in range(6) if i in (0, 4, 5) or len({r[i] for r in rows}) > 1 or (i > 1 and rows[0][i])]
        header = ("level", "file", "run", "column", "what", "do")
        screen.table("", [header[i] for i in keep], [[r[i] for i in keep] for r in rows], most=SHOWN)
    _physics.show_channels(screen, judged)
    if judged.short:
        screen.say(f"{many(judged.short, 'more run')} too short to be measured: physics and sensors leave them out")
    document = CheckDocument(
        schema="sstl.check/1",
        ok=not failures,
        failures=len(failures),
        remarks=remarks,
        findings=entries,
        physics=_physics.document(judged.remarks),
        # of 200,000 runs they take a gigabyte
        sensors=_physics.channels(judged) if as_json else [],
        files=[str(p) for p in logs],
        **({"short_left_out": judged.short} if judged.short else {}),
    )
    screen.finish(document, 1 if failures else 0)


def _headline(logs: list[Path], failed: bool, remarked: bool) -> str:
    """Return what is said of all files together; what has a remark may still be wrong, so that it is not called sound."""
    if len(logs) == 1:
        return f"{logs[0].name} {'is not sound' if failed else 'has no failure, but look at what is remarked' if remarked else 'is sound'}"
    return "Some are not sound" if failed else "None has a failure, but look at what is remarked" if remarked else "All are sound"


def _entries(path: Path, screen: Screen) -> Iterator[Entry]:
    """Yield what is wrong with a file, whatever kind it is of."""
    from sstl_cli.cli._other_files import findings as of_others
    from sstl_cli.cli._other_files import other_kind
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.kinds import kind_of
    from sstl_cli.core.parquet import open_table, schema_id_of
    from sstl_cli.core.tables import LOG, SCHEMAS, Schema
    from sstl_cli.identification.samples import FAILURE, REMARK, Finding
    from sstl_cli.importers.text_table import TextTable
    from sstl_cli.steps import check as step

    if other := other_kind(path):
        yield from map(step.Entry, of_others(path, other))
        return
    kind = kind_of(path) if path.is_file() else ""
    try:
        name = LOG.id if kind == "text" else schema_id_of(path)
        schema = SCHEMAS.get(name or LOG.id)
        if schema is None:
            yield step.Entry(Finding(FAILURE, "unknown table", "", 1, repr(name), "give a table made by sstl"))
            return
        # no columns demanded here: each missing one becomes a finding of its own
        reader: Any = TextTable(path) if kind == "text" else open_table(path, Schema(schema.id, schema.version, ()))
    except SstlError as error:
        yield step.unreadable(error)
        return
    if name is None:
        yield step.Entry(Finding(REMARK, "no provenance", "", 1, "no schema in the file; read as a log", "none needed"))
    with screen.progress("checking", reader.rows) as advance:
        yield from step.run(reader, schema, advance)

"""``sstl reproduce``: the paper's tables and figures from data, beside the published values."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sstl_cli.cli.options import Config, Force, Json, Seed
from sstl_cli.cli.render import Screen

SHOWN_OUTSIDE = 10
EPILOG = "Example: sstl reproduce --table I,II --out results --force"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("reproduce", epilog=EPILOG)(reproduce)


def reproduce(
    table: Annotated[
        str,
        typer.Option(help="I, II, III, IV, R (block R: the rig), diagnosis, figures, withheld, better, probe (several with commas), or all: the first seven."),
    ] = "all",
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="Folder for Parquet, LaTeX, HTML and SVG (made if missing)."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=2, max=1000, help="Training seeds of Table III.")] = 5,
    seed: Seed = 0,
    data_seeds: Annotated[
        int, typer.Option(min=1, max=1000, help="Data seeds of block R that are held against the committed spread.")
    ] = 3,
    spread: Annotated[
        bool,
        typer.Option(
            "--spread",
            help="Measure the sampling spread over data sets anew and write it to --out: with --table R or III of that "
            "table, seed by seed and taken up again after a stop, else of Tables I, II and IV.",
        ),
    ] = False,
    spread_seeds: Annotated[int, typer.Option(min=2, max=10_000, help="Data sets of --spread.")] = 50,
    workers: Annotated[int, typer.Option(min=1, max=256, help="Processes.")] = 2,
    gap_logs: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write logs of Table IV for sstl diagnose --against."),
    ] = None,
    force: Force = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Rebuild the paper's tables and figures from simulated recordings, beside the published values."""
    from sstl_cli.cli import _reproduce_files as files
    from sstl_cli.cli.origin import provenance as provenance_of
    from sstl_cli.core.errors import GateError, UsageError
    from sstl_cli.paper.chosen import chosen

    screen = Screen(as_json)
    tables = chosen(table)
    provenance = provenance_of(seed, [])
    if spread:
        files.measure(table, out, seed, spread_seeds, force, screen)
    if gap_logs is not None and "IV" not in tables:
        raise UsageError("needs Table IV", where="--gap-logs", fix="add --table IV", code="E805")
    if out is not None:
        files.require(out, files.names(), force)
    if gap_logs is not None:
        files.require(gap_logs, files.GAP_LOGS, force)
    # what takes seconds to load is loaded once nothing in the call is wrong
    from sstl_cli.paper.compare import VERDICTS, count
    from sstl_cli.paper.grid import text, wrapped
    from sstl_cli.steps import reproduce as step
    from sstl_cli.steps import reproduce_figures
    from sstl_cli.steps import reproduce_show as show

    with screen.progress("rebuilding", None) as advance:
        found = step.run(step.Options(tables, seed, seeds, data_seeds, workers), screen.note, advance)
    grids, facts, counts = show.grids(found), show.facts(found), count(found.compared)
    for grid in grids:
        for line in [*text(grid).splitlines(), ""]:
            screen.line(line)
    for fact in facts:
        for line in wrapped(fact):
            screen.line(line)
    for verdict, n in counts.items():
        if n:
            screen.say(f"{n:4d} entries {verdict}: {VERDICTS[verdict]}")
    written: list[str] = []
    if out is not None:
        wanted = found.figures or found.better or found.probes
        drawings = reproduce_figures.drawings(found) if wanted else []
        written = files.write(out, found, grids, drawings, facts, counts, provenance, force)
        screen.say(f"{len(written)} files -> {out}")
    elif found.figures:
        screen.note("figures are drawn with --out DIR")
    if gap_logs is not None:
        written += files.write_gap_logs(gap_logs, found, seed, provenance, force)
        screen.say(
            f"two logs; next: sstl diagnose {gap_logs / files.GAP_LOGS[0]} --against {gap_logs / files.GAP_LOGS[1]}"
        )
    document = {
        "schema": "sstl.reproduce/1",
        "tables": list(tables),
        "seed": seed,
        "seeds": seeds,
        "verdicts": counts,
        "facts": facts,
        "entries": [c.record() for c in found.compared],
        "written": written,
        **files.extras(found),
    }
    if found.outside:
        for one in found.outside[:SHOWN_OUTSIDE]:
            screen.note(one.text())
        raise GateError(
            f"{len(found.outside)} entries of block R lie outside the committed spread, the farthest: {found.outside[0].text()}",
            where="block R",
            fix="if the change is meant, measure it anew: make reproduce-seeds",
            code="E809",
        )
    screen.finish(document)

"""``sstl reproduce``: the paper's tables and figures from data, beside the published values."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from sstl_cli.cli._gathered import gathered
from sstl_cli.cli._progress import Pace
from sstl_cli.cli.options import Config, Force, Json, Seed
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.core.errors import GateError
    from sstl_cli.core.provenance import Provenance
    from sstl_cli.paper.reproduce import Options, Reproduction
    from sstl_cli.paper.written import Shown

SHOWN_OUTSIDE = 10
EPILOG = "Example: sstl reproduce --table I,II --out results --force"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("reproduce", epilog=EPILOG)(reproduce)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    table: Annotated[
        str,
        typer.Option(
            help="I, II, III, IV, R (block R: the rig), diagnosis, figures, withheld, better (with identified lag and presliding, and reversal regions), probe, tendons, distal (several with commas), or all: the first seven."
        ),
    ] = "all"
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Folder for Parquet, LaTeX, HTML and SVG (made if missing).")
    ] = None
    seeds: Annotated[int, typer.Option(min=2, max=1000, help="Training seeds of Table III.")] = 5
    seed: Seed = 0
    data_seeds: Annotated[int, typer.Option(min=1, max=1000, help="Data seeds of block R that are held against the committed spread.")] = 3
    spread: Annotated[
        bool,
        typer.Option(
            "--spread",
            help="Measure the sampling spread over data sets anew and write it to --out: with --table R or III of that "
            "table, seed by seed and taken up again after a stop, else of Tables I, II and IV.",
        ),
    ] = False
    spread_seeds: Annotated[int, typer.Option(min=2, max=10_000, help="Data sets of --spread.")] = 50
    workers: Annotated[int, typer.Option(min=1, max=256, help="Processes.")] = 2
    gap_logs: Annotated[Path | None, typer.Option(metavar="DIR", help="Write logs of Table IV for sstl diagnose --against.")] = None
    force: Force = False
    as_json: Json = False
    config: Config = None


@gathered
def reproduce(asked: Asked) -> None:
    """Rebuild the paper's tables and figures from simulated recordings, beside the published values."""
    from sstl_cli.cli.origin import provenance
    from sstl_cli.core.errors import UsageError
    from sstl_cli.paper import pace
    from sstl_cli.paper import written as files
    from sstl_cli.paper.chosen import chosen

    screen = Screen(asked.as_json)
    tables = chosen(asked.table)
    made = provenance(asked.seed, [])
    if asked.spread:
        _measure(screen, asked)
    if asked.gap_logs is not None and "IV" not in tables:
        raise UsageError("needs Table IV", where="--gap-logs", fix="add --table IV", code="E805")
    if asked.out is not None:
        files.require(asked.out, files.names(), asked.force)
    if asked.gap_logs is not None:
        files.require(asked.gap_logs, files.GAP_LOGS, asked.force)
    seconds = pace.parts(tables, asked.seeds, asked.data_seeds, asked.workers)
    with screen.progress("rebuilding", sum(seconds.values()), Pace(pace.curve(seconds))) as advance:
        # what takes seconds to load is loaded once nothing in the call is wrong
        from sstl_cli.paper import reproduce as paper

        advance(0.0)
        options = paper.Options(tables, asked.seed, asked.seeds, asked.data_seeds, asked.workers)
        found = paper.run(options, screen.note, advance)
    _end(screen, asked, found, options, made)


def _measure(screen: Screen, asked: Asked) -> NoReturn:
    """Measure the sampling spread of a table, and end."""
    from sstl_cli.core.errors import UsageError
    from sstl_cli.paper import measured

    if asked.out is None:
        raise UsageError("needs a folder", where="--spread", fix="give --out DIR", code="E804")
    with screen.progress("spread", asked.spread_seeds) as advance:
        found = measured.run(asked.table, asked.out, asked.seed, asked.spread_seeds, asked.force, advance)
    screen.line(f"spread over {asked.spread_seeds} data sets -> {found.spread}")
    screen.finish(found)


def _end(screen: Screen, asked: Asked, found: Reproduction, options: Options, made: Provenance) -> NoReturn:
    """Show what was rebuilt, write what was asked for, and end: as an error if block R left the committed spread."""
    from sstl_cli.paper import written as files

    shown = files.shown(found)
    _show(screen, shown)
    written: list[str] = []
    if asked.out is not None:
        written = files.write(asked.out, found, shown, made, asked.force)
        screen.say(f"{len(written)} files -> {asked.out}")
    elif found.figures:
        screen.note("figures are drawn with --out DIR")
    if asked.gap_logs is not None:
        written += files.write_gap_logs(asked.gap_logs, found, asked.seed, made, asked.force)
        log, other = (asked.gap_logs / name for name in files.GAP_LOGS)
        screen.say(f"two logs; next: sstl diagnose {log} --against {other}")
    screen.finish(files.document(found, shown, options, written), gate=_missed(screen, found))


def _show(screen: Screen, shown: Shown) -> None:
    from sstl_cli.paper.compare import VERDICTS
    from sstl_cli.paper.grid import text, wrapped

    for grid in shown.grids:
        for line in [*text(grid).splitlines(), ""]:
            screen.line(line)
    for fact in shown.facts:
        for line in wrapped(fact):
            screen.line(line)
    for verdict, n in shown.counts.items():
        if n:
            screen.say(f"{n:4d} entries {verdict}: {VERDICTS[verdict]}")


def _missed(screen: Screen, found: Reproduction) -> GateError | None:
    """Return the gate that is missed if entries of block R lie outside the committed spread; the farthest are told here."""
    from sstl_cli.core.errors import GateError

    if not found.outside:
        return None
    for one in found.outside[:SHOWN_OUTSIDE]:
        screen.note(one.text())
    return GateError(
        f"{len(found.outside)} entries of block R lie outside the committed spread, the farthest: {found.outside[0].text()}",
        where="block R",
        fix="if the change is meant, measure it anew: make reproduce-seeds",
        code="E809",
    )

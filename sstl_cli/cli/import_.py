"""``sstl import``: recordings of any known format into the log table."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Force, Json
from sstl_cli.cli.render import Screen, many

if TYPE_CHECKING:
    from sstl_cli.importers.mapping import Mapping
    from sstl_cli.steps.import_ import Import

EPILOG = """Examples:

  sstl import run1.csv run2.csv --out log.parquet

  sstl import rec.txt -o log.parquet --map "time_s=col1:ms,tension_in_n=col5-col6:N,tension_out_n=col7:lbf,system=act"

  sstl import bend_*.mat --mapping rig.toml --out log.parquet --on-gap fill

  sstl import --guess bend_*.csv --out rig.toml
"""
SHOWN = 20


def register(app: typer.Typer) -> None:
    """Add the subcommand to the program."""
    app.command(
        "import",
        epilog=EPILOG,
        help=(
            "Import recordings (CSV, TSV, text, Parquet, MAT, HDF5, NPZ, TDMS, MCAP, ROS bags) into a log table. "
            "Canonical columns need no mapping; exit code 3 says that samples were set aside."
        ),
    )(import_)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Recordings.", show_default=False)]
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Log table to write (Parquet).")] = None
    mapping: Annotated[Path | None, typer.Option("--mapping", metavar="FILE.toml", help="Mapping file.")] = None
    map_: Annotated[str | None, typer.Option("--map", help="Mapping in short: target=source[:unit],...")] = None
    format_: Annotated[str | None, typer.Option("--format", help="Format id, instead of detection.")] = None
    on_gap: Annotated[str | None, typer.Option("--on-gap", help="split, fill or fail (default split).")] = None
    manifest: Annotated[Path | None, typer.Option("--manifest", help="CSV with labels by file name.")] = None
    merge: Annotated[
        str | None, typer.Option("--merge", help="append (files follow in time), channels (each with its clock) or rows (row n of each).")
    ] = None
    guess: Annotated[
        bool, typer.Option("--guess", help="Propose a mapping for files of one kind, with reasons; what it cannot know it asks.")
    ] = False
    json_: Json = False
    force: Force = False
    config: Config = None


@gathered
def import_(asked: Asked) -> None:
    """Import recordings into a log table."""
    from sstl_cli.cli.origin import refuse
    from sstl_cli.core.errors import UsageError

    if asked.guess:
        refuse("a proposal", ("--mapping", "--map", "--on-gap", "--manifest", "--merge"), "write it into the mapping that is proposed")
    screen, mapping = Screen(asked.json_), asked.mapping
    if mapping is not None and asked.map_ is None and mapping.suffix.lower() != ".toml":
        raise UsageError(
            f"--mapping takes a TOML file, found '{mapping}'", fix=f"for a mapping in short write --map '{mapping}'", code="E346"
        )
    if asked.guess:
        _guess(screen, asked)
    if asked.out is None:
        raise UsageError(
            "--out is missing", fix=f"add --out {asked.files[0].stem}.parquet, or --guess to see what the file holds", code="E346"
        )
    _import(screen, asked, asked.out)


def _import(screen: Screen, asked: Asked, out: Path) -> NoReturn:
    """Import the recordings, and end."""
    from sstl_cli.cli.origin import provenance as provenance_of
    from sstl_cli.core.files import keep_safe, require_writable
    from sstl_cli.core.runs import write_runs
    from sstl_cli.importers.base import head_of, members, require_recording
    from sstl_cli.importers.sources import read_manifest
    from sstl_cli.steps.import_ import manifest_of, no_tensions, provenance_extra, run

    files, mapping = asked.files, asked.mapping
    chosen = _mapping(screen, asked)
    table = manifest_of(asked.manifest, mapping, chosen)
    for path in files:
        require_recording(path)
    parts = [m for path in files for m in members(path)]
    keep_safe([*parts, *filter(None, (table,))], "the recordings")
    require_writable(out, asked.force)
    if len(files) == 1:
        head_of(files[0])
    labels = read_manifest(table) if table is not None else {}
    provenance = provenance_of(None, [*parts, *filter(None, (mapping, table))], provenance_extra(chosen))
    with screen.progress("import, bytes", float(sum(p.stat().st_size for p in parts))) as advance:
        result = run(files, chosen, wanted=asked.format_, manifest=labels, advance=advance)
        write_runs(out, result.runs, provenance, asked.force, lambda: bool(result.tendons))
    other = no_tensions(chosen)
    _show(screen, result, out, len(files) - len({bad.path for bad in result.bad}), other)
    screen.finish(result.document(str(out), other), aside=result.set_aside)


def _mapping(screen: Screen, asked: Asked) -> Mapping:
    """Return the mapping: that of the file, with what the options say on top."""
    from sstl_cli.importers.inline import targets_of
    from sstl_cli.importers.mapping import still_open
    from sstl_cli.steps.import_ import mapping_of

    answered = targets_of(asked.map_ or "")
    for question in still_open(asked.mapping, answered)[1:] if asked.mapping is not None else ():
        screen.note(f"{asked.mapping}, line {question.line} asks too: {question.text}")
    return mapping_of(asked.mapping, asked.map_, asked.on_gap, asked.merge)


def _show(screen: Screen, result: Import, out: Path, files: int, other: dict[str, str]) -> None:
    """Show what was imported from the files that were not set aside; ``other`` are the units of columns that hold no tension."""
    c = result.counts
    rows = [[r.file, r.format, r.runs, r.samples] for r in result.recordings]
    screen.say(f"Imported {many(c.runs, 'run')} from {many(files, 'file')} -> {out}")
    screen.table("", ["file", "format", "runs", "samples"], rows, most=SHOWN)
    found = ", ".join(f"{n} {k.replace('_', ' ')}" for k, n in c.found.items() if n)
    if found:
        screen.say(f"found: {found}" + (f" (gap: more than {c.gap_s:.4g} s)" if c.gap_s else ""))
    for reason, n in sorted(c.notes.set_aside.items()):
        screen.note(f"set aside: {n} samples, {reason}")
    for name, n in sorted(c.blanked.items()):
        screen.note(f"set aside: {many(n, 'value')} of {name}, infinite or beyond any sensor, taken as not measured")
    if c.set_aside:
        screen.note(f"set aside in all: {c.set_aside} samples, {c.set_aside_pct:.2f} % of those read")
    for bad in result.bad:
        error = bad.error
        screen.note(f"set aside: {bad.path.name}, [{error.code}] {error.what}" + (f"; {error.fix}" if error.fix else ""))
    for name, unit in other.items():
        side = "an output" if name == "tension_out_n" else "an input"
        screen.note(f"{name} holds {side} in {unit}, not a tension: slopes and offsets are not in N/N and N")
    for text in [*(r.sentence() for r in result.clocks), *result.remarks]:
        screen.note(text)


def _guess(screen: Screen, asked: Asked) -> NoReturn:
    """Propose a mapping, and end."""
    from sstl_cli.core.documents.logs import GuessDocument, QuestionPart
    from sstl_cli.core.files import keep_safe, require_outputs, write_text
    from sstl_cli.importers.base import members, require_recording
    from sstl_cli.importers.guess import guess

    files = asked.files
    for path in files:
        require_recording(path)
    keep_safe([m for path in files for m in members(path)], "the recordings")
    require_outputs(asked.force, asked.out)
    found = guess(files, asked.format_)
    if asked.out is not None:
        write_text(asked.out, found.toml, asked.force)
    for line in found.toml.splitlines():
        screen.line(line)
    for line in [*found.reasons, *found.preview]:
        screen.note(line)
    for question in found.questions:
        screen.note(f"line {question.line} asks: {question.text}")
    document = GuessDocument(
        schema="sstl.import-guess/1",
        file=str(files[0]),
        files=[str(f) for f in files],
        format=found.format,
        mapping=found.toml,
        reasons=found.reasons,
        questions=[QuestionPart(line=q.line, target=q.target, text=q.text) for q in found.questions],
        preview=found.preview,
    )
    screen.finish(document)

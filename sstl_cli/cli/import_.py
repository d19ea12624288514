"""``sstl import``: recordings of any known format into the log table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from sstl_cli.cli.options import Config, Force, Json
from sstl_cli.cli.render import Screen, many

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


def import_(
    files: Annotated[list[Path], typer.Argument(help="Recordings.", show_default=False)],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Log table to write (Parquet).")] = None,
    mapping: Annotated[Path | None, typer.Option("--mapping", metavar="FILE.toml", help="Mapping file.")] = None,
    map_: Annotated[str | None, typer.Option("--map", help="Mapping in short: target=source[:unit],...")] = None,
    format_: Annotated[str | None, typer.Option("--format", help="Format id, instead of detection.")] = None,
    on_gap: Annotated[str | None, typer.Option("--on-gap", help="split, fill or fail (default split).")] = None,
    manifest: Annotated[Path | None, typer.Option("--manifest", help="CSV with labels by file name.")] = None,
    merge: Annotated[
        str | None,
        typer.Option(
            "--merge", help="append (files follow in time), channels (each with its clock) or rows (row n of each)."
        ),
    ] = None,
    guess: Annotated[bool, typer.Option("--guess", help="Propose a mapping for files of one kind, with reasons; what it cannot know it asks.")] = False,
    json_: Json = False,
    force: Force = False,
    config: Config = None,
) -> None:
    """Import recordings into a log table."""
    from sstl_cli.core.errors import UsageError

    screen = Screen(json_)
    if mapping is not None and map_ is None and mapping.suffix.lower() != ".toml":
        raise UsageError(
            f"--mapping takes a TOML file, found '{mapping}'", fix=f"for a mapping in short write --map '{mapping}'", code="E346"
        )
    if guess:
        _guess(screen, files, format_, out, force)
    if out is None:
        raise UsageError(
            "--out is missing", fix=f"add --out {files[0].stem}.parquet, or --guess to see what the file holds", code="E346"
        )
    _import(screen, files, out, mapping, map_, format_, on_gap, manifest, merge, force)


def _import(
    screen: Screen,
    files: list[Path],
    out: Path,
    mapping: Path | None,
    map_: str | None,
    format_: str | None,
    on_gap: str | None,
    manifest: Path | None,
    merge: str | None,
    force: bool,
) -> None:
    from sstl_cli.cli.origin import provenance as provenance_of
    from sstl_cli.core.errors import EXIT_SET_ASIDE
    from sstl_cli.core.files import keep_safe, require_writable
    from sstl_cli.core.runs import write_runs
    from sstl_cli.importers.base import head_of, members
    from sstl_cli.importers.inline import inline_mapping, targets_of, with_policy
    from sstl_cli.importers.mapping import Mapping, read_mapping, still_open
    from sstl_cli.importers.sources import read_manifest
    from sstl_cli.steps.import_ import provenance_extra, run

    answered = targets_of(map_ or "")
    for question in still_open(mapping, answered)[1:] if mapping is not None else ():
        screen.note(f"{mapping}, line {question.line} asks too: {question.text}")
    chosen = read_mapping(mapping, answered) if mapping is not None else Mapping()
    if map_ is not None:
        chosen = inline_mapping(map_, chosen)
    chosen = with_policy(chosen, on_gap=on_gap, merge=merge)
    table = manifest or (_beside(mapping, chosen.manifest) if chosen.manifest else None)
    parts = [m for path in files for m in members(path)]
    keep_safe([*parts, *filter(None, (table,))], "the recordings")
    require_writable(out, force)
    if len(files) == 1:
        head_of(files[0])
    labels = read_manifest(table) if table is not None else {}
    provenance = provenance_of(None, [*parts, *filter(None, (mapping, table))], provenance_extra(chosen))
    with screen.progress("import, bytes", float(sum(p.stat().st_size for p in parts))) as advance:
        result = run(files, chosen, wanted=format_, manifest=labels, advance=advance)
        write_runs(out, result.runs, provenance, force, lambda: bool(result.tendons))
    document = {"schema": "sstl.import/1", "out": str(out), **result.document()}
    if "not_a_tension" in provenance.extra:
        document["not_a_tension"] = provenance.extra["not_a_tension"]
    _show(screen, document, [r.sentence() for r in result.clocks])
    screen.finish(document, EXIT_SET_ASIDE if result.counts.set_aside or result.bad else 0)


def _beside(mapping: Path | None, name: str) -> Path:
    return mapping.parent / name if mapping is not None else Path(name)


def _show(screen: Screen, document: dict[str, Any], clocks: list[str]) -> None:
    rows = [[r["file"], r["format"], r["runs"], r["samples"]] for r in document["recordings"]]
    screen.say(f"Imported {many(document['runs'], 'run')} from {many(len(rows), 'file')} -> {document['out']}")
    screen.table("", ["file", "format", "runs", "samples"], rows, most=SHOWN)
    found = ", ".join(f"{n} {k.replace('_', ' ')}" for k, n in document["found"].items() if n)
    if found:
        screen.line(f"found: {found}" + (f" (gap: more than {document['gap_s']:.4g} s)" if document["gap_s"] else ""))
    for reason, n in document["set_aside_by"].items():
        screen.note(f"set aside: {n} samples, {reason}")
    if document["set_aside"]:
        screen.note(
            f"set aside in all: {document['set_aside']} samples, {document['set_aside_pct']:.2f} % of those read"
        )
    for bad in document["files_set_aside"]:
        screen.note(f"set aside: {bad['file']}, [{bad['code']}] {bad['message']}" + (f"; {bad['fix']}" if bad["fix"] else ""))
    for name, unit in document.get("not_a_tension", {}).items():
        side = "an output" if name == "tension_out_n" else "an input"
        screen.note(f"{name} holds {side} in {unit}, not a tension: slopes and offsets are not in N/N and N")
    for text in [*clocks, *document["remarks"]]:
        screen.note(text)


def _guess(screen: Screen, files: list[Path], format_: str | None, out: Path | None, force: bool) -> None:
    from sstl_cli.core.files import keep_safe, require_writable, write_text
    from sstl_cli.importers.base import members
    from sstl_cli.importers.guess import guess

    keep_safe([m for path in files for m in members(path)], "the recordings")
    if out is not None:
        require_writable(out, force)
    found = guess(files, format_)
    if out is not None:
        write_text(out, found.toml, force)
    for line in found.toml.splitlines():
        screen.line(line)
    for line in [*found.reasons, *found.preview]:
        screen.note(line)
    for question in found.questions:
        screen.note(f"line {question.line} asks: {question.text}")
    screen.finish(
        {
            "schema": "sstl.import-guess/1",
            "file": str(files[0]),
            "files": [str(f) for f in files],
            "format": found.format,
            "mapping": found.toml,
            "reasons": found.reasons,
            "questions": [{"line": q.line, "target": q.target, "text": q.text} for q in found.questions],
            "preview": found.preview,
        }
    )

"""``sstl export``: a controller as C or JSON, a mapping as ONNX, a log for other programs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from sstl_cli.cli import _controller as shared
from sstl_cli.cli.options import Config, Force, Json
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.control.controller import Options

EPILOG = "Example: sstl export theta.parquet --format c --config-id CP-040 --out firmware/"
FOR_LOGS = ("csv", "mat", "mcap")


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("export", epilog=EPILOG)(export)


def export(
    source: Annotated[Path, typer.Argument(metavar="INPUT", help="Theta table, parameters (JSON), simulator (TOML), mapping model, or log.")],
    out_name: Annotated[
        str, typer.Option("--out", "-o", metavar="PATH", help="Output file; for c also a folder (NAME/ makes it).")
    ],
    format_: Annotated[
        Literal["c", "json", "onnx", "csv", "mat", "mcap"],
        typer.Option("--format", "-f", help="c, json: controller; onnx: mapping model; csv, mat, mcap: log."),
    ] = "json",
    config_id: shared.ConfigId = None,
    method: Annotated[
        Literal["none", "no-bias", "proposed", "DI"] | None,
        typer.Option(help="Whose lines (default: proposed, else DI)."),
    ] = None,
    model: shared.ModelFile = None,
    beta_p: shared.BetaP = None,
    beta_r: shared.BetaR = None,
    bias_theta: shared.BiasTheta = None,
    real: Annotated[Literal["double", "float"], typer.Option(help="Number type of the C code.")] = "double",
    t_max: shared.TMax = None,
    max_rate: shared.MaxRate = None,
    max_jump: shared.MaxJump = None,
    lead: shared.Lead = None,
    reversal: shared.Reversal = None,
    presliding: shared.Presliding = None,
    doubled: shared.Doubled = None,
    dt: shared.Period = None,
    force: Force = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Write a controller, a mapping or a log in a form that other programs and a rig can use."""
    from sstl_cli.core.errors import EXIT_DONE, EXIT_SET_ASIDE, SstlError
    from sstl_cli.core.files import require_writable

    screen = Screen(as_json)
    out = Path(out_name)
    document: dict[str, Any] = {"schema": "sstl.export/1", "format": format_, "input": str(source)}
    if not source.is_file():
        raise SstlError("file not found" if not source.exists() else "is not a file", where=str(source), code="E130")
    if format_ != "c":
        require_writable(out, force)
    if format_ in FOR_LOGS:
        from sstl_cli.steps import export_log

        export_log.run(source, out, format_, force)
        screen.say(f"Wrote the log as {format_} -> {out}")
        screen.finish({**document, "out": [str(out)]})
    if format_ == "onnx":
        from sstl_cli.core.files import atomic
        from sstl_cli.mapping import export_onnx

        with atomic(out, force) as temporary:
            export_onnx(source, temporary)
        screen.say(f"Wrote the mapping -> {out}")
        screen.finish({**document, "out": [str(out)]})
    options = shared.controller_options(source, t_max, max_rate, max_jump, lead, reversal, presliding, doubled, dt)
    cases, aside = shared.load_cases(source, model, (beta_p, beta_r, bias_theta), config_id)
    from sstl_cli.steps import export_controller as step

    lines, chosen = step.lines_for(cases, method)
    aside.update({c.config_id: f"method '{chosen}' is not possible" for c in cases if c.config_id not in lines})
    if format_ == "json":
        from sstl_cli.core.files import write_json

        write_json(out, step.to_json(lines, chosen, options), force)
        written = [out]
    else:
        written = _write_c(lines, config_id, chosen, options, real, out_name, force)
    shown = ", ".join(list(lines)[:6]) + (", ..." if len(lines) > 6 else "")
    screen.say(f"Wrote the controller (method {chosen}) of {shown} -> {', '.join(map(str, written))}")
    if aside:
        screen.note(f"set aside {len(aside)}: " + "; ".join(f"{k}: {v}" for k, v in list(aside.items())[:5]))
    document.update(
        out=[str(p) for p in written],
        method=chosen,
        configurations=list(lines),
        set_aside=aside,
        options=options.model_dump(mode="json"),
    )
    screen.finish(document, EXIT_SET_ASIDE if aside and format_ == "json" else EXIT_DONE)


def _write_c(
    lines: dict[str, Any],
    config_id: str | None,
    method: str,
    options: Options,
    real: Literal["double", "float"],
    out_name: str,
    force: bool,
) -> list[Path]:
    import re

    from sstl_cli.control.parameters import index_of
    from sstl_cli.core.errors import UsageError
    from sstl_cli.core.files import make_folder, require_writable, write_text
    from sstl_cli.steps import export_controller as step

    name = list(lines)[index_of(list(lines), config_id)]
    out = Path(out_name)
    folder = out.is_dir() or out_name.endswith(("/", os.sep))
    if out.suffix and not folder and out.suffix not in (".c", ".h"):
        raise UsageError("is not a name for C source", where=str(out), fix="give a folder or a .c file", code="E412")
    base = out / "sstl_controller" if folder else out.with_suffix("")
    if not re.fullmatch(r"[A-Za-z0-9_.-]+", base.name):
        raise UsageError(
            f"'{base.name}' is not a portable file name", where="--out", fix="use letters, digits, _ . -", code="E412"
        )
    header, source = base.with_name(base.name + ".h"), base.with_name(base.name + ".c")
    code = step.to_c(name, lines[name], method, options, real, header.name)
    if folder:
        make_folder(out)
    for path in (header, source):
        require_writable(path, force)
    write_text(header, code.header, force)
    write_text(source, code.source, force)
    return [header, source]

"""``sstl export``: a controller as C or JSON, a mapping as ONNX, a log for other programs."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NoReturn

import typer

from sstl_cli.cli import _controller as shared
from sstl_cli.cli._gathered import gathered
from sstl_cli.cli.options import Config, Force, Json
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.control.controllers import Controllers
    from sstl_cli.core.documents.control import ExportDocument

EPILOG = "Example: sstl export theta.parquet --format c --config-id CP-040 --out firmware/"
FOR_LOGS = ("csv", "mat", "mcap")
# what only a controller has, and only its C code
OF_CONTROLLERS = ("--config-id", "--method", "--model", *shared.OF_BIASES, *shared.OF_SETTINGS)
OF_C = ("--real",)


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("export", epilog=EPILOG)(export)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a call asks for."""

    source: Annotated[
        Path, typer.Argument(metavar="INPUT", help="Theta table, parameters (JSON), simulator (TOML), mapping model, or log.")
    ]
    out_name: Annotated[str, typer.Option("--out", "-o", metavar="PATH", help="Output file; for c also a folder (NAME/ makes it).")]
    format_: Annotated[
        Literal["c", "json", "onnx", "csv", "mat", "mcap"],
        typer.Option("--format", "-f", help="c, json: controller; onnx: mapping model; csv, mat, mcap: log."),
    ] = "json"
    config_id: shared.ConfigId = None
    method: Annotated[
        Literal["none", "no-bias", "proposed", "DI"] | None, typer.Option(help="Whose lines (default: proposed, else DI).")
    ] = None
    model: shared.ModelFile = None
    biases: shared.Biases
    real: Annotated[Literal["double", "float"], typer.Option(help="Number type of the C code.")] = "double"
    settings: shared.Settings
    force: Force = False
    as_json: Json = False
    config: Config = None

    @property
    def out(self) -> Path:
        """The output as a path; its name tells a folder that is still to be made."""
        return Path(self.out_name)

    def written(self) -> ExportDocument:
        """Return the document of an export that is one file and nothing else."""
        from sstl_cli.core.documents.control import ExportDocument

        return ExportDocument(schema="sstl.export/1", format=self.format_, input=str(self.source), out=[str(self.out)])


@gathered
def export(asked: Asked) -> None:
    """Write a controller, a mapping or a log in a form that other programs and a rig can use."""
    from sstl_cli.core.errors import SstlError
    from sstl_cli.core.files import require_writable

    screen, source = Screen(asked.as_json), asked.source
    if not source.is_file():
        raise SstlError(
            "file not found" if not source.exists() else "is not a file", where=str(source), fix="correct the path", code="E130"
        )
    _refuse(asked.format_)
    if asked.format_ != "c":
        require_writable(asked.out, asked.force)
    if asked.format_ in FOR_LOGS:
        from sstl_cli.steps import export_log

        export_log.run(source, asked.out, asked.format_, asked.force)
        screen.say(f"Wrote the log as {asked.format_} -> {asked.out}")
        screen.finish(asked.written())
    if asked.format_ == "onnx":
        from sstl_cli.core.files import atomic
        from sstl_cli.mapping import export_onnx, load_model

        model = load_model(source)
        with atomic(asked.out, asked.force) as temporary:
            export_onnx(model, temporary)
        screen.say(f"Wrote the mapping -> {asked.out}")
        screen.finish(asked.written())
    _controller(screen, asked)


def _refuse(form: str) -> None:
    """Refuse options that belong to other formats."""
    from sstl_cli.cli.origin import refuse

    if form == "json":
        refuse("a controller as json", OF_C, "leave it out, or give --format c")
    elif form != "c":
        what = "a mapping as onnx" if form == "onnx" else f"a log as {form}"
        refuse(what, (*OF_CONTROLLERS, *OF_C), "leave it out, or give --format c or json")


def _controller(screen: Screen, asked: Asked) -> NoReturn:
    """Write the lines of a controller as C or JSON, and end."""
    from sstl_cli.core.documents.control import ControllerSettings, ExportDocument
    from sstl_cli.steps import export_controller as step

    source = asked.source
    stored = shared.stored_in(source)
    options = shared.controller_options(stored, asked.settings)
    cases, aside = shared.load_cases(source, stored, asked.model, asked.biases, asked.config_id)
    found = step.controllers(cases, aside, asked.method, options)
    lines, aside = found.lines, found.set_aside
    if asked.format_ == "json":
        found.write(asked.out, asked.force)
        written = [asked.out]
    else:
        written = _write_c(asked, found)
    shown = ", ".join(list(lines)[:6]) + (", ..." if len(lines) > 6 else "")
    screen.say(f"Wrote the controller (method {found.method}) of {shown} -> {', '.join(map(str, written))}")
    if aside:
        screen.note(f"set aside {len(aside)}: " + "; ".join(f"{k}: {v}" for k, v in list(aside.items())[:5]))
    document = ExportDocument(
        schema="sstl.export/1",
        format=asked.format_,
        input=str(source),
        out=[str(p) for p in written],
        method=found.method,
        configurations=list(lines),
        set_aside=aside,
        options=ControllerSettings.model_validate(options.model_dump(mode="json")),
    )
    # C source drives one configuration: that others are set aside takes nothing from it
    screen.finish(document, aside=bool(aside) and asked.format_ == "json")


def _write_c(asked: Asked, found: Controllers) -> list[Path]:
    """Write the C source of one configuration; return its header and its source."""
    from sstl_cli.control.controllers import c_name
    from sstl_cli.core.files import make_folder, require_followed, require_writable

    require_followed(asked.out)
    name, out = found.chosen(asked.config_id), asked.out
    if out.exists() and not out.is_dir():
        # the files take its name with other endings: a device would be none of them
        require_writable(out, force=True)
    folder = out.is_dir() or asked.out_name.endswith(("/", os.sep))
    if folder:
        make_folder(out)
    else:
        c_name(out, "--out")
    return list(found.write_c(out / "sstl_controller" if folder else out, name, asked.real, asked.force))

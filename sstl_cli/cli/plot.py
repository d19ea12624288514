"""``sstl plot``: one figure as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sstl_cli.cli.options import Config, Force, Json

EXAMPLE = "Example: sstl plot log.parquet phases.parquet theta.parquet --out loop.png --kind loop"
FORMATS = ("png", "svg", "pdf")


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("plot", epilog=EXAMPLE)(plot)


def plot(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="What to draw; further files add phases or fitted lines.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Picture to write: .png, .svg or .pdf.")],
    kind: Annotated[str | None, typer.Option("--kind", "-k", help="loop, time, overview, theta, waterfall, where, ...")] = None,
    run_id: Annotated[str | None, typer.Option("--run", help="The run to draw, for figures of one run.")] = None,
    tendon: Annotated[
        str | None, typer.Option(help="The tendon to draw, of a diagnosis that judges several (default: the one with the largest gap).")
    ] = None,
    force: Force = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Draw one figure of the report as a picture file."""
    from sstl_cli.cli.render import Screen
    from sstl_cli.core.errors import UsageError
    from sstl_cli.core.files import atomic, require_writable
    from sstl_cli.core.kept import fonts_beside

    screen = Screen(as_json)
    form = out.suffix.lower().removeprefix(".")
    if form not in FORMATS:
        raise UsageError(f"no picture format '{out.suffix}'", where=str(out), fix="end the name in .png, .svg or .pdf", code="E610")
    require_writable(out, force)
    fonts_beside(out)

    from sstl_cli.core.documents.outputs import PlotDocument
    from sstl_cli.reporting.drawing import save
    from sstl_cli.reporting.load import load
    from sstl_cli.steps.plot import run

    choice = run(load(files), kind, run_id, tendon)
    with atomic(out, force) as temporary:
        save(choice.module, choice.data, temporary, form, choice.title)
    screen.say(f"wrote {out}: {choice.alt}")
    screen.finish(PlotDocument(schema="sstl.plot/1", out=str(out), kind=choice.kind, description=choice.alt))

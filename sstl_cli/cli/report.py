"""``sstl report``: one page from any mix of outputs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sstl_cli.cli.options import Config, Force, Json

EXAMPLE = "Example: sstl report log.parquet theta.parquet diagnosis.json --out report.html"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("report", epilog=EXAMPLE)(report)


def report(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Logs, Theta, phases, commands, scores, diagnoses, ...")],
    out: Annotated[Path, typer.Option("--out", "-o", help="HTML file to write.")],
    title: Annotated[str | None, typer.Option("--title", help="Heading of the page.")] = None,
    force: Force = False,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Make one self-contained HTML page of logs, parameters, scores and diagnoses."""
    from sstl_cli.cli.render import Screen
    from sstl_cli.core.files import require_writable, write_text
    from sstl_cli.core.kept import fonts_beside

    screen = Screen(as_json)
    require_writable(out, force)
    fonts_beside(out)

    from sstl_cli.core.documents.outputs import ReportDocument
    from sstl_cli.reporting.load import load
    from sstl_cli.steps.report import DEFAULT_TITLE, run

    inputs = load(files)
    page = run(inputs, DEFAULT_TITLE if title is None else title)
    write_text(out, page.html, force)
    size = len(page.html.encode())
    for document in inputs.diagnosis:
        screen.note_versions(document.package_version, document.file)
    screen.say(f"wrote {out} ({size / 1e6:.2f} MB): {', '.join(page.sections)}")
    told = ReportDocument(
        schema="sstl.report/1",
        out=str(out),
        bytes=size,
        sections=list(page.sections),
        inputs=[{"kind": k, "file": n, "sha256": h} for k, n, h in inputs.files],
    )
    screen.finish(told)

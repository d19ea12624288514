"""Put the sections whose inputs were given into one self-contained page."""

from __future__ import annotations

import base64
import hashlib
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from sstl_cli import __version__
from sstl_cli.core.errors import printable
from sstl_cli.reporting import sections
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.table import table

TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class Page:
    """A finished page and the names of its sections."""

    html: str
    sections: tuple[str, ...]


def page(inputs: Inputs, title: str) -> Page:
    """Return the page; the same inputs and title give the same bytes.

    Parameters
    ----------
    inputs : Inputs
        What ``load`` read.
    title : str
        Heading and window title.
    """
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        finalize=_shown,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made = []
    for name, module in sections.find():
        if inputs.has(module.NEEDS):
            html = environment.get_template(f"{name}.html.j2").render(module.context(inputs))
            made.append({"name": name, "title": module.TITLE, "html": Markup(html)})
    # style and script are our own files; read without template syntax so that their braces stay as they are
    style = (TEMPLATES / "page.css").read_text(encoding="utf-8")
    script = (TEMPLATES / "page.js").read_text(encoding="utf-8")
    files = table("Inputs of this report", ["kind", "file", "SHA-256"], inputs.files)
    listing = environment.get_template("files.html.j2").render(table=files)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    html = environment.get_template("page.html.j2").render(
        title=printable(title),
        version=__version__,
        sections=made,
        files=inputs.files,
        file_table=Markup(listing),
        style=Markup(style),
        script=Markup(script),
        script_hash=Markup(f"sha256-{digest}"),
    )
    return Page(html, tuple(s["name"] for s in made))


def _shown(value: object) -> object:
    """Return what a template shows: text of the data with its control characters and marks of direction escaped, all else as it is."""
    return printable(value) if type(value) is str else value

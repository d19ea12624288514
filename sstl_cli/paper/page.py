"""One self-contained HTML page: verdicts, tables, figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from jinja2 import Environment, PackageLoader, StrictUndefined

from sstl_cli.paper.compare import VERDICTS
from sstl_cli.paper.grid import Grid


@dataclass(frozen=True)
class Shown:
    """A figure in the page: name, inline SVG (already safe), caption."""

    name: str
    svg: str
    caption: str


def page(grids: Sequence[Grid], figures: Sequence[Shown], counts: Mapping[str, int], facts: Sequence[str], command: str) -> str:
    """Return the page; it needs no network and no script."""
    environment = Environment(
        loader=PackageLoader("sstl_cli.paper", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.get_template("page.html").render(
        grids=grids, figures=figures, counts=counts, verdicts=VERDICTS, facts=facts, command=command
    )

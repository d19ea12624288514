"""Turn a figure module's data into a picture: inline SVG for the page, or a file of its own."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib  # the commands have seen to its folders (core.kept.fonts_beside)
import numpy as np
from markupsafe import Markup
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from sstl_cli.core.errors import printable
from sstl_cli.reporting import palette
from sstl_cli.reporting.scales import scales

STYLE: dict[str, object] = {
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "text.color": palette.INK,
    "axes.edgecolor": palette.INK,
    "axes.labelcolor": palette.INK,
    "xtick.color": palette.INK,
    "ytick.color": palette.INK,
    "grid.color": palette.GRID,
    "axes.grid": True,
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.5,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
    "path.simplify": True,
    "axes.unicode_minus": True,
    "figure.constrained_layout.use": True,
    # run names are data: a dollar sign in them must not start a formula
    "text.parse_math": False,
}


@dataclass(frozen=True)
class Picture:
    """An inline SVG with its description for readers who cannot see it, and a caption."""

    svg: Markup
    alt: str
    caption: str


def picture(module: ModuleType, data: Any, name: str, caption: str = "", **look: Any) -> Picture:
    """Return the figure as inline SVG whose ink, grid and paper follow the page's theme.

    Parameters
    ----------
    module : module
        One of ``reporting.figures``: ``figure(data)`` gives (width, height) in inch and the grid of axes,
        ``draw(axes, data)`` draws, ``alt(data)`` describes.
    data : object
        What ``module.data`` returned.
    name : str
        Unique name in the page; keeps the ids of several pictures apart.
    caption : str, optional
        Text under the picture.
    """
    buffer = io.StringIO()
    with _style({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure = _drawn(module, data)
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    description = printable(module.alt(data))
    return Picture(_inline(buffer.getvalue(), name, description, scales(figure)), description, caption)


def save(module: ModuleType, data: Any, path: Path, kind: str, title: str = "") -> None:
    """Write one figure as a png, svg or pdf file on white paper, the same bytes each time, with a title above it where one is given."""
    dates = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with _style({"savefig.facecolor": "white", "svg.hashsalt": "sstl", "svg.fonttype": "path", "pdf.fonttype": 42}):
        _drawn(module, data, title).savefig(path, format=kind, dpi=200, metadata=dates[kind])


def drawn(module: ModuleType, data: Any, title: str = "") -> Figure:
    """Return one figure on white paper, to show in a notebook or to draw on."""
    with _style({"figure.facecolor": "white"}):
        figure = _drawn(module, data, title)
        # laid out now: the style ends here
        figure.draw_without_rendering()
    return figure


def label(text: object, longest: int = 28) -> str:
    """Return text fit for an axis or legend: printable, short, never hidden by a leading underscore."""
    plain = printable(str(text))
    plain = plain if len(plain) <= longest else plain[: longest - 1] + "…"
    # matplotlib leaves out labels that begin with an underscore
    return "\u200a" + plain if plain.startswith("_") else plain


def heat(axes: Any, values: Any, rows: Sequence[str], columns: Sequence[str], form: str, top: float, turn: bool = True) -> None:
    """Draw a matrix as cells with their values; empty cells stay paper, so both themes read well."""
    values = np.ma.masked_invalid(np.asarray(values, dtype=float))
    cmap = LinearSegmentedColormap.from_list("sstl", ["#dbe9f6", "#56b4e9", palette.BLUE, "#00304d"])
    shown = np.ma.masked_where(np.ma.getmaskarray(values) | (np.abs(np.ma.filled(values, 0.0)) < 1e-12), values)
    axes.pcolormesh(np.abs(shown), cmap=cmap, vmin=0, vmax=top or 1.0, edgecolors=palette.PAPER, linewidth=1.0)
    size = 8.5 if len(columns) <= 12 else 6.5
    for (i, j), value in np.ndenumerate(np.ma.filled(shown, np.nan)):
        if not np.isnan(value):
            axes.text(
                j + 0.5,
                i + 0.5,
                form.format(value),
                ha="center",
                va="center",
                fontsize=size,
                color=_readable_on(cmap(min(abs(value) / (top or 1.0), 1.0))),
            )
    axes.set_xticks(
        np.arange(len(columns)) + 0.5,
        [label(c, 22) for c in columns],
        rotation=60 if turn else 0,
        ha="right" if turn else "center",
        rotation_mode="anchor" if turn else None,
    )
    axes.set_yticks(np.arange(len(rows)) + 0.5, [label(r, 24) for r in rows])
    axes.invert_yaxis()
    axes.grid(False)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)


def _readable_on(colour: tuple[float, float, float, float]) -> str:
    """Return black or white, whichever has the higher contrast on a colour (WCAG 2 relative luminance)."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour[:3]]
    luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    return "#000000" if (luminance + 0.05) / 0.05 > 1.05 / (luminance + 0.05) else "#ffffff"


def _drawn(module: ModuleType, data: Any, title: str = "") -> Figure:
    size, grid = module.figure(data)
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(*grid, squeeze=False)
    module.draw(axes[0, 0] if grid == (1, 1) else axes, data)
    if title:
        figure.suptitle(label(title), fontsize=10)
    return figure


@contextmanager
def _style(more: Mapping[str, object]) -> Iterator[None]:
    settings: Any = {**STYLE, **more}
    with matplotlib.rc_context(settings), warnings.catch_warnings():
        # the page's browser has the glyphs; only the width estimate uses this font
        warnings.filterwarnings("ignore", message=".*[Gg]lyph.*")
        yield


def _inline(svg: str, name: str, description: str, axes: str) -> Markup:
    body = svg[svg.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.S)
    # inside HTML the namespaces are implied; no address of any kind stays in the page
    body = re.sub(r'\sxmlns(:xlink)?="[^"]*"', "", body)
    body = body.replace("xlink:href=", "href=")
    safe = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
    body = re.sub(r'id="([^"]+)"', rf'id="{safe}-\1"', body)
    body = re.sub(r'href="#([^"]+)"', rf'href="#{safe}-\1"', body)
    body = re.sub(r"url\(#([^)]+)\)", rf"url(#{safe}-\1)", body)
    # groups are named for editors of the figure only
    body = re.sub(r'<g id="[^"]*-(?:line2d|text|patch|matplotlib\.axis|xtick|ytick|PolyCollection|LineCollection)_\d+">', "<g>", body)
    # a hundredth of a point is finer than any screen
    body = re.sub(r' d="[^"]*"', lambda d: re.sub(r"(\.\d\d)\d+", r"\1", d.group()), body)
    for colour, variable in palette.CSS.items():
        body = body.replace(colour, variable)
    width = re.search(r'width="([\d.]+)pt"', body)
    natural = f"{float(width.group(1)) * 1.45:.0f}" if width else "450"
    where = f'data-axes="{Markup.escape(axes)}" tabindex="0" ' if axes else ""
    opening = f'<svg role="img" aria-label="{Markup.escape(description)}" {where}style="width:{natural}px" '
    body = re.sub(r'<svg\s+(?:height="[^"]*"|width="[^"]*"|\s)*', lambda _: opening, body, count=1)
    body = re.sub(r'(<svg[^>]*?)\s(?:width|height)="[\d.]+pt"', r"\1", body)
    body = re.sub(r'(<svg[^>]*?)\s(?:width|height)="[\d.]+pt"', r"\1", body)
    return Markup(re.sub(r"\n\s*", "\n", body).strip())

"""What is printed: every result as plain tables of text, for the terminal, LaTeX and HTML alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sstl_cli.paper.compare import CONTRADICTED, DIFFERS, MET, UNJUDGED, Compared
from sstl_cli.paper.published import titles
from sstl_cli.paper.settings import LOCATIONS

MARKS = {MET: "=", CONTRADICTED: "!", DIFFERS: "x", UNJUDGED: "?"}
LEGEND = "= within 2 sd   ! the paper contradicts itself here   x differs   ? not judged"
NAMES = {
    "linear": "Linear regression",
    "plain": "Plain MLP",
    "plain-inv": "Plain MLP + L_inv",
    "skip": "Skip-MLP",
    "skip-inv": "Skip-MLP + L_inv",
    "R": "Pearson R",
    "rmse_id": "RMSE_id",
    "slope": "fit slope",
    "bias": "fit bias",
    "rmse_fit": "RMSE_fit",
    "rmse_p": "RMSE Gp",
    "rmse_r": "RMSE Gr",
    "total": "Total",
    "rmse": "mean RMSE",
    "red": "mean reduction %",
    "recovery": "of DI's %",
}
WIDTH = 80


@dataclass(frozen=True)
class Grid:
    """A table of text: title, header, rows and notes; the first ``labels`` columns are words."""

    name: str
    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    labels: int = 1


def text(grid: Grid) -> str:
    """Return the table as lines of at most 80 characters."""
    widths = [max(len(r[i]) for r in (grid.header, *grid.rows)) for i in range(len(grid.header))]

    def line(cells: Sequence[str]) -> str:
        parts = [
            c.ljust(w) if i < grid.labels else c.rjust(w) for i, (c, w) in enumerate(zip(cells, widths, strict=True))
        ]
        return " ".join(parts).rstrip()

    out = [grid.title, line(grid.header), "-" * min(sum(widths) + len(widths) - 1, WIDTH)]
    out += [line(r) for r in grid.rows]
    for note in grid.notes:
        out += wrapped(note)
    return "\n".join(out)


def wrapped(note: str) -> list[str]:
    """Return a note in lines of at most 80 characters."""
    lines, current = [], ""
    for word in note.split():
        if current and len(current) + 1 + len(word) > WIDTH:
            lines.append(current)
            current = "  " + word
        else:
            current = f"{current} {word}" if current else word
    return [*lines, current] if current else lines


def entry_grids(compared: Sequence[Compared]) -> list[Grid]:
    """Return one table a published table: the paper's value, ours, its spread over seeds, and a mark."""
    grids = []
    for table in ("I", "II", "bias", "III"):
        own = [c for c in compared if c.entry.table == table]
        if not own:
            continue
        rows = tuple(
            (
                label(c.entry.row),
                label(c.entry.column),
                _printed(c),
                number(c.ours, c.entry.decimals),
                _spread(c),
                MARKS[c.verdict],
            )
            for c in own
        )
        grids.append(
            Grid(table, titles()[table], ("row", "entry", "paper", "ours", "over seeds", ""), rows, _notes(own), 2)
        )
    return grids


def tracking_grids(compared: Sequence[Compared]) -> list[Grid]:
    """Return Table IV in three blocks: paper, ours as stated (S), ours as explained (E)."""
    stated, explained = (
        {(c.entry.row, c.entry.column): c for c in compared if c.entry.table == "IV" and c.block == b}
        for b in ("stated", "explained")
    )
    if not stated:
        return []
    grids = []
    header = ("method", "at", "RMSE", "S", "E", "STD", "S", "E", "MAPE", "S", "E", "red.", "S", "E")
    for trajectory in ("sinusoid", "random"):
        rows = []
        for row in dict.fromkeys(r for r, _ in stated if r.startswith(trajectory)):
            for place in LOCATIONS:
                cells = [row.split(" ", 1)[1], place]
                for measure in ("rmse", "std", "mape", "red"):
                    s, e = (b.get((row, f"{measure}_{place}")) for b in (stated, explained))
                    digits = 1 if measure in ("mape", "red") else 2
                    cells.append(number(s.entry.value, digits) if s else "-")
                    cells += [number(c.ours, digits) + MARKS[c.verdict] if c else "-" for c in (s, e)]
                rows.append(tuple(cells))
        title = f"Table IV, {trajectory}: paper, ours as stated (S), ours as explained (E); N, N, %, %"
        own = [c for c in compared if c.entry.table == "IV" and c.entry.row.startswith(trajectory)]
        grids.append(Grid(f"IV-{trajectory}", title, header, tuple(rows), _notes(own), 2))
    rows = []
    for c in (c for c in compared if c.entry.table == "summary" and c.block == "stated"):
        other = next((e for e in compared if e.block == "explained" and e.entry == c.entry), None)
        rows.append(
            (
                c.entry.row,
                label(c.entry.column),
                c.entry.text(),
                number(c.ours, c.entry.decimals) + MARKS[c.verdict],
                number(other.ours, other.entry.decimals) + MARKS[other.verdict] if other else "-",
            )
        )
    grids.append(
        Grid("IV-summary", titles()["summary"], ("row", "entry", "paper", "stated", "explained"), tuple(rows), (), 2)
    )
    return grids


def label(name: str) -> str:
    """Return the words for a row or column."""
    return NAMES.get(name, name.replace("_", " "))


def number(value: float | None, digits: int) -> str:
    """Return a number with fixed digits, or a dash."""
    return "-" if value is None or value != value else f"{value:.{digits}f}"


def _printed(c: Compared) -> str:
    return c.entry.text() + (f" +-{c.entry.spread:g}" if c.entry.spread is not None else "")


def _spread(c: Compared) -> str:
    if c.mean is None or c.sd is None:
        return "-"
    return f"{c.mean:.{c.entry.decimals}f} +-{c.sd:.{c.entry.decimals + 1}f}"


def _notes(own: Iterable[Compared]) -> tuple[str, ...]:
    own = list(own)
    reasons: dict[str, list[str]] = {}
    for c in own:
        if c.entry.contradicted:
            reasons.setdefault(c.entry.contradicted, []).append(f"{label(c.entry.row)} {label(c.entry.column)}")
    notes = [f"The paper against itself, {', '.join(dict.fromkeys(where))}: {why}." for why, where in reasons.items()]
    return (LEGEND, *notes)

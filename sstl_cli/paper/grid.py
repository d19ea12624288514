"""What is printed: every result as plain tables of text, for the terminal, LaTeX and HTML alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from sstl_cli.paper.compare import CONTRADICTED, DIFFERS, MET, UNJUDGED, Compared
from sstl_cli.paper.published import titles
from sstl_cli.paper.settings import LOCATIONS

MARKS = {MET: "=", CONTRADICTED: "!", DIFFERS: "x", UNJUDGED: "?"}
LEGEND = "= within 2 sd; ! the paper contradicts itself; x off by so many %; ? not judged"
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
    "red": "reduction %",
    "recovery": "of DI's %",
}
WIDTH = 80
#: from here on percent are given without decimals
LEAST_WHOLE_PCT = 0.5


@dataclass(frozen=True)
class Grid:
    """A table of text: where the data come from, title, header, rows and notes; the first ``labels`` columns are words."""

    name: str
    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    labels: int = 1
    source: str = ""


def text(grid: Grid) -> str:
    """Return the table as lines of at most 80 characters."""
    widths = [max(len(r[i]) for r in (grid.header, *grid.rows)) for i in range(len(grid.header))]

    def line(cells: Sequence[str]) -> str:
        parts = [c.ljust(w) if i < grid.labels else c.rjust(w) for i, (c, w) in enumerate(zip(cells, widths, strict=True))]
        return " ".join(parts).rstrip()

    out = [*wrapped(grid.source), *wrapped(grid.title), line(grid.header), "-" * min(sum(widths) + len(widths) - 1, WIDTH)]
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


#: where the data of a table come from, by block
SOURCES = {
    "stated": "Data: loops simulated from configurations whose constants were fitted to Tables I and II "
    "(NP and ND: to Table III); recorded with noise, then segmented.",
    "rig": "Data: block R, recordings of the elastic rig with noise, segmented; the rig's constants were fitted to "
    "means, range and scatter of Tables I and II and to two rows of Table IV.",
}
TRACKED = {"stated": "S", "fitted": "F", "rig": "R"}


def entry_grids(compared: Sequence[Compared], block: str = "stated") -> list[Grid]:
    """Return one table a published table: the paper's value, ours, its spread over data sets, and a mark."""
    grids = []
    for table in ("I", "II", "bias", "III"):
        own = [c for c in compared if c.entry.table == table and c.block == block and c.ours is not None]
        if not own:
            continue
        rows = tuple(
            (label(c.entry.row), label(c.entry.column), _printed(c), number(c.ours, c.entry.decimals), _spread(c), mark(c)) for c in own
        )
        name, title = (table, titles()[table]) if block == "stated" else (f"R-{table}", f"On the rig: {titles()[table]}")
        header = ("row", "entry", "paper", "ours", "over data sets", "")
        grids.append(Grid(name, title, header, rows, _notes(own), 2, SOURCES[block]))
    return grids


def tracking_grids(compared: Sequence[Compared]) -> list[Grid]:
    """Return Table IV: paper, ours as stated (S), under fitted settings (F) and on the rig (R)."""
    by_block = {
        b: {(c.entry.table, c.entry.row, c.entry.column): c for c in compared if c.block == b and c.ours is not None} for b in TRACKED
    }
    shown = [b for b in TRACKED if any(k[0] == "IV" for k in by_block[b])]
    if not shown:
        return []
    grids = []
    for trajectory in ("sinusoid", "random"):
        for measures, unit in ((("rmse", "std"), "RMSE and STD, N"), (("mape", "red"), "MAPE and reduction, %")):
            grids.append(_tracking_grid(by_block, shown, trajectory, measures, unit))
    grids += _summary_grids(by_block, shown)
    return grids


Blocks = Mapping[str, Mapping[tuple[str, str, str], Compared]]


def _tracking_grid(blocks: Blocks, shown: Sequence[str], trajectory: str, measures: tuple[str, str], unit: str) -> Grid:
    keys = dict.fromkeys(
        (row, place)
        for b in shown
        for _, row, column in blocks[b]
        for place in LOCATIONS
        if row.startswith(trajectory) and column.endswith(place)
    )
    rows, own = [], []
    for row, place in keys:
        cells = [row.split(" ", 1)[1], place]
        for measure in measures:
            digits = 2 if measure in ("rmse", "std") else 1
            found = [blocks[b].get(("IV", row, f"{measure}_{place}")) for b in shown]
            known = next((c for c in found if c is not None), None)
            cells.append(number(known.entry.value, digits) if known else "-")
            cells += [number(c.ours, digits) + mark(c) if c else "-" for c in found]
            own += [c for c in found if c is not None]
        if any(c != "-" for c in cells[2:]):
            rows.append(tuple(cells))
    letters = tuple(TRACKED[b] for b in shown)
    header = ("method", "at", *(cell for m in measures for cell in (m.upper() if m != "red" else "red.", *letters)))
    name = f"IV-{trajectory}-{measures[0]}"
    return Grid(name, f"Table IV, {trajectory}: {unit}", header, tuple(rows), _notes(own), 2, _tracking_source(shown))


def _tracking_source(shown: Sequence[str]) -> str:
    said = {
        "stated": "S: play-line plant, settings as stated",
        "fitted": "F: the same plant under 14 numbers fitted to this table",
        "rig": "R: the elastic rig, learned from its noisy loops",
    }
    return "Data: " + "; ".join(said[b] for b in shown) + ". First column of each: the paper."


def _summary_grids(blocks: Blocks, shown: Sequence[str]) -> list[Grid]:
    grids = []
    for table in ("summary", "headline"):
        keys = dict.fromkeys(k for b in shown for k in blocks[b] if k[0] == table)
        if not keys:
            continue
        rows = []
        for key in keys:
            found = [blocks[b].get(key) for b in shown]
            entry = next(c.entry for c in found if c is not None)
            cells = [number(c.ours, entry.decimals) + mark(c) if c else "-" for c in found]
            over = blocks.get("rig", {}).get(key)
            sd = f"{over.sd:.{entry.decimals + 1}f}" if over is not None and over.sd is not None else "-"
            rows.append((entry.row, label(entry.column), entry.text(), *cells, sd))
        header = ("row", "entry", "paper", *(TRACKED[b] for b in shown), "sd of R")
        grids.append(Grid(f"IV-{table}", titles()[table], header, tuple(rows), (LEGEND,), 2))
    return grids


def count_grid(counts: Mapping[tuple[str, str, str], Mapping[str, int]]) -> Grid:
    """Return how many entries were fitted, how many predicted, and how each fared."""
    verdicts = (MET, CONTRADICTED, DIFFERS, UNJUDGED)
    rows = [
        (block, table, origin, *(str(found[v]) if found[v] else "-" for v in verdicts)) for (block, table, origin), found in counts.items()
    ]
    for origin in ("fitted", "predicted"):
        total = [sum(f[v] for (_, _, o), f in counts.items() if o == origin) for v in verdicts]
        rows.append(("all", "", origin, *(str(n) if n else "-" for n in total)))
    return Grid(
        "counts",
        "Entries fitted and entries predicted, and how they fare",
        ("block", "table", "", "met", "contradicted", "differs", "not judged"),
        tuple(rows),
        ("fitted: a constant behind our value was set to this entry, so that agreement shows only that the fit works.",),
        3,
    )


def mark(c: Compared) -> str:
    """Return the mark of a verdict; a value that differs says by how many percent."""
    relative = c.relative_pct
    if c.verdict != DIFFERS or relative is None:
        return MARKS[c.verdict]
    # a difference that is there is not said to be nothing
    return f"{MARKS[c.verdict]}{relative:+.{0 if abs(relative) >= LEAST_WHOLE_PCT else 1}f}"


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

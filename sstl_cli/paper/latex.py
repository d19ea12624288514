"""The tables as LaTeX (booktabs)."""

from __future__ import annotations

from collections.abc import Sequence

from sstl_cli.paper.grid import Grid

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}


def escaped(text: str) -> str:
    """Return text that LaTeX prints as it stands."""
    return "".join(_SPECIAL.get(c, c) for c in text).replace("+-", r"$\pm$")


def tabular(grid: Grid) -> str:
    """Return one table environment."""
    columns = "l" * grid.labels + "r" * (len(grid.header) - grid.labels)
    body = [" & ".join(escaped(c) for c in row) + r" \\" for row in (grid.header, *grid.rows)]
    lines = [
        r"\begin{table}",
        r"\centering",
        *([rf"{{\footnotesize {escaped(grid.source)}\par}}"] if grid.source else []),
        rf"\caption{{{escaped(grid.title)}}}",
        rf"\label{{tab:{grid.name}}}",
        rf"\begin{{tabular}}{{{columns}}}",
        r"\toprule",
        body[0],
        r"\midrule",
        *body[1:],
        r"\bottomrule",
        r"\end{tabular}",
        *(rf"\par\footnotesize {escaped(note)}" for note in grid.notes),
        r"\end{table}",
    ]
    return "\n".join(lines)


def document(grids: Sequence[Grid]) -> str:
    """Return a document that compiles by itself; needs the package booktabs."""
    head = [r"\documentclass{article}", r"\usepackage{booktabs}", r"\usepackage[margin=15mm]{geometry}", r"\begin{document}"]
    return "\n".join([*head, "\n\n".join(tabular(g) for g in grids), r"\end{document}"]) + "\n"

"""The paper's tables from Python: rebuilt from data, beside the published values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path

import pandas as pd

from sstl_cli.api.log import Log
from sstl_cli.core.documents.outputs import ReproduceDocument
from sstl_cli.core.provenance import Provenance
from sstl_cli.paper import chosen, measured, written
from sstl_cli.paper import reproduce as rebuilding
from sstl_cli.paper.compare import table_of

__all__ = ["ReproduceDocument", "Reproduction", "measure_spread", "reproduce"]


@dataclass(frozen=True)
class Reproduction:
    """Tables of the paper as they were rebuilt, beside the published values."""

    _found: rebuilding.Reproduction = field(repr=False)
    _options: rebuilding.Options = field(repr=False)

    @cached_property
    def _said(self) -> written.Shown:
        return written.shown(self._found)

    @property
    def entries(self) -> pd.DataFrame:
        """Every published entry beside ours: table, row, column, both values, spread, verdict and reason."""
        frame: pd.DataFrame = table_of(self._found.compared).to_pandas()
        return frame

    @property
    def tables(self) -> dict[str, pd.DataFrame]:
        """The tables as ``sstl reproduce`` prints them, words in every cell, by title; of titles that come again the later ones are numbered."""
        made: dict[str, pd.DataFrame] = {}
        for grid in self._said.grids:
            again = sum(title.startswith(grid.title) for title in made)
            made[f"{grid.title} ({again + 1})" if again else grid.title] = pd.DataFrame(grid.rows, columns=list(grid.header))
        return made

    @property
    def data(self) -> dict[str, pd.DataFrame]:
        """Theta tables, errors of the mapping and scores that the entries come from, as far as they were rebuilt."""
        return {name.removesuffix(".parquet"): table.to_pandas() for name, (table, _) in written.beside(self._found).items()}

    @property
    def verdicts(self) -> dict[str, int]:
        """How many entries have each verdict."""
        return dict(self._said.counts)

    @property
    def facts(self) -> list[str]:
        """The sentences that sum the tables up."""
        return list(self._said.facts)

    @property
    def outside(self) -> list[str]:
        """The entries of block R that left the committed spread, which the command fails for."""
        return [one.text() for one in self._found.outside]

    def gap_logs(self) -> tuple[Log, Log]:
        """Return recordings of Table IV under the fitted settings, and what the stated ones predict, to ``diagnose(..., against=...)``.

        Raises
        ------
        SstlError
            If Table IV was not rebuilt.
        """
        fitted, stated = written.gap_runs(self._found, self._options.seed)
        return Log(tuple(fitted)), Log(tuple(stated))

    @property
    def document(self) -> ReproduceDocument:
        """What ``sstl reproduce --json`` prints (``sstl.reproduce/1``)."""
        return written.document(self._found, self._said, self._options)

    def write(self, path: str | PathLike[str], force: bool = False) -> list[str]:
        """Write Parquet, LaTeX, HTML and SVG into a folder, as ``sstl reproduce --out`` does; return their names.

        Raises
        ------
        SstlError
            If a file exists and ``force`` is not given, or the folder cannot be made.
        """
        folder = Path(path)
        written.require(folder, written.names(), force)
        return written.write(folder, self._found, self._said, Provenance("python", self._options.seed, {}), force)

    def __repr__(self) -> str:
        told = ", ".join(f"{n} {verdict}" for verdict, n in self.verdicts.items() if n)
        return f"Reproduction({', '.join(self._options.tables)}{': ' + told if told else ''})"


def reproduce(tables: str | Sequence[str] = "all", *, seed: int = 0, seeds: int = 5, data_seeds: int = 3, workers: int = 2) -> Reproduction:
    """Rebuild the paper's tables and figures from simulated recordings, as ``sstl reproduce`` does: minutes to hours.

    With several ``workers`` a script needs ``if __name__ == "__main__":`` around its calls, as processes of their own do the work.

    Parameters
    ----------
    tables : str or sequence of str
        Some of I, II, III, IV, R, diagnosis, figures, withheld, better, probe, tendons and distal, or all: the first seven.
    seed : int
        Seed of the data.
    seeds : int
        Training seeds of Table III.
    data_seeds : int
        Data seeds of block R that are held against the committed spread.
    workers : int
        Processes.

    Raises
    ------
    SstlError
        For a table that there is not.

    Examples
    --------
    >>> found = reproduce("I", workers=1)
    >>> found
    Reproduction(I: 10 met)
    >>> found.entries[["row", "column", "published"]].head(1).values.tolist()
    [['pull', 'R', 0.967]]
    """
    named = chosen.chosen(tables if isinstance(tables, str) else ",".join(tables))
    options = rebuilding.Options(named, seed, seeds, data_seeds, workers)
    return Reproduction(rebuilding.run(options), options)


def measure_spread(
    path: str | PathLike[str], table: str = "all", *, seed: int = 0, seeds: int = 50, force: bool = False
) -> ReproduceDocument:
    """Measure the sampling spread over data sets into a folder, as ``sstl reproduce --spread`` does: an hour; a stopped one goes on.

    Parameters
    ----------
    path : str or path
        The folder; made if missing.
    table : str
        R or III for the spread of that table, else that of Tables I, II and IV.
    seed : int
        The data sets are those of the seeds behind it.
    seeds : int
        How many data sets.
    force : bool
        Replace the file of an earlier measurement.

    Raises
    ------
    SstlError
        If the file exists and ``force`` is not given, or there is no such table.

    Examples
    --------
    >>> measure_spread("spread", "III", seeds=50).spread  # doctest: +SKIP
    'spread/spread_mapping.csv'
    """
    chosen.chosen(table)
    return measured.run(table, Path(path), seed, seeds, force)

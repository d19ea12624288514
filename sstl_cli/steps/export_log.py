"""A log table as CSV, MAT or MCAP, for MATLAB, PlotJuggler and Foxglove."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sstl_cli.core.errors import SstlError, UsageError, nearest
from sstl_cli.core.files import atomic
from sstl_cli.core.parquet import open_table
from sstl_cli.core.run_parts import LABELS, SIGNALS
from sstl_cli.core.runs import Run, read_runs, units_of
from sstl_cli.core.tables import LOG, TENDON

FORMATS = ("csv", "mat", "mcap")
# nanoseconds in 64 bits
MAX_MCAP_S = 1.8e10
MAX_MAT_BYTES = 2**31 - 2**20
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_CSV_COLUMNS = [c.name for c in LOG.columns]


@dataclass(frozen=True)
class Export:
    """What was written."""

    path: Path
    format: str
    runs: int
    samples: int


@dataclass(frozen=True)
class About:
    """What is known of a log before its runs are: the unit of every column, whether runs name a tendon, its name for messages."""

    units: dict[str, str]
    tendons: bool
    where: str

    @classmethod
    def of(cls, stated: dict[str, str], tendons: bool, where: str) -> About:
        """Return it with the units of its tensions as stated; one that is no tension has its own."""
        own = {"tension_in_n": stated["unit_in"], "tension_out_n": stated["unit_out"]}
        return cls({c.name: c.unit for c in LOG.columns} | own, tendons, where)


def run(path_in: Path, path_out: Path, fmt: str, force: bool = False) -> Export:
    """Write a log table in another format, run by run.

    Parameters
    ----------
    path_in : Path
        Log table (Parquet).
    path_out : Path
        File to write, atomically.
    fmt : str
        ``csv``, ``mat`` (version 5, a struct array ``runs``) or ``mcap`` (one JSON topic a run).

    Raises
    ------
    UsageError
        If the format is unknown.
    SstlError
        If the log cannot be read, does not fit the format, or the output cannot be written.
    """
    _known(fmt)
    # a file that holds no log is told before a run of it is read
    schema = open_table(path_in, LOG).file.schema_arrow
    return write(read_runs(path_in), About.of(units_of(schema), TENDON.name in schema.names, str(path_in)), path_out, fmt, force)


def write(runs: Iterable[Run], about: About, path_out: Path, fmt: str, force: bool = False) -> Export:
    """Write runs in another format; parameters and errors as those of ``run``."""
    writer = _known(fmt)
    counted = _Counted(runs)
    with atomic(path_out, force) as temporary:
        writer(counted, temporary, about)
    return Export(path_out, fmt, counted.runs, counted.samples)


def _known(fmt: str) -> Callable[[_Counted, Path, About], None]:
    writers = {"csv": _csv, "mat": _mat, "mcap": _mcap}
    if fmt not in writers:
        raise UsageError(f"unknown format '{fmt}'", where="--format", fix=nearest(fmt, FORMATS), code="E360")
    return writers[fmt]


export_log = run


class _Counted:
    """Runs passed on and counted."""

    def __init__(self, source: Iterable[Run]) -> None:
        self.source, self.runs, self.samples = source, 0, 0

    def __iter__(self) -> Iterator[Run]:
        for one in self.source:
            if not len(one):
                continue
            self.runs += 1
            self.samples += len(one)
            yield one


def safe_cell(text: str | None) -> str:
    """Return a label that no spreadsheet takes for a formula and no terminal for a command."""
    if text is None:
        return ""
    text = "".join(c if c.isprintable() else " " for c in text)
    return "'" + text if text.startswith(_FORMULA) else text


def _csv(runs: _Counted, path: Path, about: About) -> None:
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        names = [*_CSV_COLUMNS, *([TENDON.name] if about.tendons else [])]
        writer.writerow(names)
        units = about.units
        if (units["tension_in_n"], units["tension_out_n"]) != ("N", "N"):
            # a row of units, which import reads; without it the numbers would come back as newtons
            writer.writerow([safe_cell(units.get(n, "")) for n in names])
        for one in runs:
            columns: list[Any] = []
            for name in names:
                value = getattr(one, name)
                if isinstance(value, np.ndarray):
                    # repr of a float is the shortest text that reads back to the same bits
                    columns.append(["" if v != v else v for v in value.tolist()])
                else:
                    columns.append([value if isinstance(value, float) else safe_cell(value)] * len(one))
            writer.writerows(zip(*columns, strict=True))


def _mat(runs: _Counted, path: Path, about: About) -> None:
    from scipy.io import savemat

    fields = [*LABELS, *SIGNALS]
    held: list[tuple[Any, ...]] = []
    size = 0
    for one in runs:
        row: list[Any] = []
        for name in fields:
            value = getattr(one, name)
            empty: Any = np.empty((0, 0)) if name in SIGNALS or name == "lead_mm" else ""
            row.append(value.reshape(-1, 1) if isinstance(value, np.ndarray) else empty if value is None else value)
        size += sum(v.nbytes for v in row if isinstance(v, np.ndarray))
        if size > MAX_MAT_BYTES:
            raise SstlError(
                "is larger than the 2 GiB that a MATLAB file of version 5 holds",
                where=about.where,
                fix="split the log, or export csv or mcap",
                code="E361",
            )
        held.append(tuple(row))
    table = np.empty(len(held), dtype=[(f, object) for f in fields])
    for i, items in enumerate(held):
        table[i] = items
    savemat(path, {"runs": table, "units": {n: about.units[n] for n in SIGNALS}}, long_field_names=True)
    with open(path, "r+b") as file:
        # the library writes the date here; the same log must give the same bytes
        file.write(b"MATLAB 5.0 MAT-file, written by sstl export".ljust(116))


def _mcap(runs: _Counted, path: Path, about: About) -> None:
    try:
        from mcap.writer import CompressionType, Writer
    except ImportError:
        raise SstlError("MCAP needs the library 'mcap'", where=about.where, fix="pip install 'sstl-cli[robot]'", code="E308") from None

    names = [n for n in SIGNALS if n != "time_s"]
    units = about.units
    schema = {
        "type": "object",
        "properties": {n: {"type": "number", "description": units[n]} for n in SIGNALS}
        | {n: {"type": "string"} for n in LABELS if n != "lead_mm"}
        | {"lead_mm": {"type": "number"}},
    }
    with open(path, "wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="", library="sstl")
        schema_id = writer.register_schema("sstl.log", "jsonschema", json.dumps(schema, sort_keys=True).encode())
        for one in runs:
            labels = {n: getattr(one, n) for n in LABELS if getattr(one, n) is not None}
            topic = "/" + "".join(c if c.isalnum() or c in "_-." else "_" for c in one.run_id)
            channel = writer.register_channel(topic, "json", schema_id, {k: str(v) for k, v in labels.items()})
            tail = json.dumps(labels)[1:]
            begin = min(float(one.time_s[0]), 0.0)
            if float(one.time_s[-1]) - begin > MAX_MCAP_S:
                raise SstlError(
                    "time goes beyond what MCAP can hold (584 years)",
                    where=f"{about.where}, run {one.run_id!r}",
                    fix="is time_s in s? export csv or mat instead",
                    code="E362",
                )
            present = [(n, getattr(one, n).tolist()) for n in names if getattr(one, n) is not None]
            for i, t in enumerate(one.time_s.tolist()):
                values = {"time_s": t} | {n: v[i] for n, v in present if v[i] == v[i]}
                at = round((t - begin) * 1e9)
                writer.add_message(channel, at, (json.dumps(values)[:-1] + ", " + tail).encode(), at, sequence=i)
        writer.finish()

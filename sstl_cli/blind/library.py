"""The library that the verdict's weights are learned from: one table, one row a candidate of a case."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import groupby
from pathlib import Path
from typing import Any

import pyarrow as pa

from sstl_cli.blind.learning import Example, examples, right_answer, without_answer
from sstl_cli.blind.schedule import Job
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core.errors import SstlError
from sstl_cli.core.parquet import TableReader, open_table, write_table
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.tables import Column, Schema
from sstl_cli.diagnosis.features import CandidateRow, LogRow, Rows
from sstl_cli.diagnosis.free import LOOP
from sstl_cli.diagnosis.residuals import Leftover, Misfit

_S, _F = pa.string(), pa.float32()
# numbers of a candidate and of its log, in the order of their rows
# a rule looks at what was held out, no weight is learned for it
OWN = tuple(f.name for f in fields(CandidateRow) if f.name not in ("ids", "kind", "held"))
LOG = tuple(f.name for f in fields(LogRow))
LATER = ("strain", "jumps", "wanders", "grown")
COUNTS = ("strengths", "outside", "samples", "systems", "configurations")

LIBRARY = Schema(
    "sstl.blind.library",
    1,
    (
        Column("case", _S, meaning="neutral name of the case"),
        Column("simulator", _S, meaning="which simulator made the recordings"),
        Column("kind", _S, meaning="single, none, pair, excluded, unlisted, nominal or poor; without: searched again without its effects"),
        Column("strength", _F, "1", meaning="gap over the RMS of the noise"),
        Column("answer", _S, meaning="what should be said: effects joined by +, nothing, or ? for unknown"),
        Column("ids", _S, meaning="effects of the candidate joined by +"),
        Column("channel", _S, meaning="output, recorder or beside"),
        *(Column(n, _F, meaning="see CandidateRow") for n in OWN),
        Column("held", _F, nullable=True, meaning="see CandidateRow; not in older libraries"),
        *(
            Column(f"log_{n}", _F, nullable=n in LATER, meaning="see LogRow" + ("; not in older libraries" if n in LATER else ""))
            for n in LOG
        ),
    ),
)


@dataclass(frozen=True)
class Facts:
    """How a library was made: seeds as inclusive ranges; ``accepted`` where its cases ask what has changed."""

    cases: int
    simulators: list[str]
    seeds: list[list[int]]
    quick: bool
    accepted: bool = False


def case_name(drawn: Job | CaseTruth) -> str:
    """Return the name of a case of a library; unlike that of a blind set it tells where the case comes from."""
    return f"{drawn.simulator}-{drawn.seed}"


def labelled(case: str, truth: CaseTruth, rows: Rows) -> Example:
    """Return the rows of a case with the truth that they are learned against."""
    return Example(case, truth.simulator, truth.kind, float(truth.strength), rows, right_answer(truth))


def without(case: Example) -> Example | None:
    """Return a case of which nobody knows the effect, with what is left of its evidence; None where that could not be told."""
    return next((w for e in examples([case]) if (w := without_answer(e)) is not None), None)


def to_table(cases: Sequence[Example]) -> pa.Table:
    """Return cases as the table of a library (cases without any candidate have no row)."""
    found: list[dict[str, object]] = []
    for case in cases:
        log = {f"log_{n}": _stored(getattr(case.rows.log, n)) for n in LOG}
        head = {
            "case": case.name,
            "simulator": case.simulator,
            "kind": case.kind,
            "strength": case.strength,
            "answer": "+".join(case.answer),
        }
        # what has no name has a prior of its own
        for c in [c for c in case.rows.candidates if LOOP.id not in c.ids]:
            own = {n: float(getattr(c, n)) for n in OWN}
            found.append({**head, "ids": "+".join(c.ids), "channel": c.kind, **own, "held": c.held, **log})
    return pa.Table.from_pylist(found, schema=LIBRARY.arrow())


def write_library(path: Path, table: pa.Table, provenance: Provenance, force: bool = False) -> None:
    """Write the table of a library.

    Raises
    ------
    SstlError
        If the file exists without ``force``.
    """
    write_table(path, table, LIBRARY, provenance, force)


def read_library(path: Path) -> list[Example]:
    """Return the examples of a library; cases with a hidden effect or on poor movements teach nothing.

    Raises
    ------
    SstlError
        If the file is no library, or holds no example.
    """
    found = examples(cases_of(open_table(path, LIBRARY)))
    if not found:
        raise SstlError("holds no case to learn from", where=str(path), fix="make a larger library", code="E955")
    return found


def cases_of(reader: TableReader) -> Iterator[Example]:
    """Yield the cases of a library in the order of the file."""
    scatters = bool(_told(reader).get("accepted"))
    for _, rows in groupby(reader.table().to_pylist(), key=lambda row: row["case"]):
        yield _case(list(rows), scatters)


def _told(reader: TableReader) -> Mapping[str, Any]:
    """Return what a library says of how it was made."""
    extra = reader.metadata.get("extra")
    return extra if isinstance(extra, dict) else {}


def facts_of(path: Path) -> Facts:
    """Return how a library was made."""
    extra = _told(open_table(path, LIBRARY))
    if not {"cases", "simulators", "seeds", "quick"} <= set(extra):
        raise SstlError("does not say how it was made", where=str(path), fix="make it with sstl blind library", code="E955")
    return Facts(extra["cases"], extra["simulators"], extra["seeds"], extra["quick"], bool(extra.get("accepted")))


def _case(group: Sequence[Mapping[str, Any]], scatters: bool) -> Example:
    first = group[0]
    log = LogRow(**{n: _number(n, first.get(f"log_{n}")) for n in LOG})
    candidates = tuple(
        CandidateRow(ids=_ids(r["ids"]), kind=r["channel"], **{n: _number(n, r[n]) for n in OWN}, held=r.get("held")) for r in group
    )
    base = _leftover(log, log.base_chi2, log.base_worst_z, log.base_skewness)
    best = _leftover(log, log.best_chi2, log.best_worst_z, log.best_skewness)
    rows = Rows(log, candidates, base, best, scatters=scatters)
    return Example(first["case"], first["simulator"], first["kind"], float(first["strength"]), rows, _ids(first["answer"]))


def _stored(value: float | None) -> float | None:
    return None if value is None else float(value)


def _number(name: str, value: float | None) -> Any:
    return None if value is None else int(value) if name in COUNTS else float(value)


def _ids(text: str) -> tuple[str, ...]:
    return tuple(text.split("+")) if text else ()


def _leftover(log: LogRow, chi2: float, worst_z: float, skewness: float) -> Leftover:
    """Return what a model left as far as the row tells: the worst test has lost its name."""
    worst = Misfit("worst", worst_z, 0.0, "")
    return Leftover(log.samples, chi2, log.best_lag_one, log.best_kurtosis, skewness, (worst,))

"""The rows of a Theta table, held as plain values: a row as a document of its own takes kilobytes, of a million runs gigabytes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import overload

import pyarrow as pa

from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.core.tables import TENDON, THETA

NAMES = tuple(ThetaRow.model_fields)
# what says which run it is, and how it went; the rest are numbers
LABELS = ("run_id", "config_id", "system", "location", "lead_mm", "status", "tendon")
NUMBERS = tuple(n for n in NAMES if n not in LABELS)
# rows of a table that are made at once
AT_ONCE = 65_536

Labels = tuple[str, str | None, str, str | None, float | None, str, str | None]
Numbers = tuple[float | int | None, ...]


class ThetaRows(Sequence[ThetaRow]):
    """Rows in the order of the runs; each is made when it is asked for."""

    def __init__(self, rows: Iterable[ThetaRow] = ()) -> None:
        self._held: list[tuple[Labels, Numbers]] = []
        # labels, statuses and rows without a line repeat: one of each is enough
        self._texts: dict[str | None, str | None] = {}
        self._numbers: dict[Numbers, Numbers] = {}
        for row in rows:
            self.add({name: getattr(row, name) for name in NAMES})

    def add(self, values: dict[str, str | float | None]) -> None:
        """Append a row, given by its fields."""
        one = self._texts.setdefault
        labels = tuple(one(v, v) if isinstance(v := values[n], str) and n != "run_id" else v for n in LABELS)
        numbers = tuple(values[n] for n in NUMBERS)
        if values["gamma_p"] is None and values["gamma_r"] is None:
            numbers = self._numbers.setdefault(numbers, numbers)  # type: ignore[arg-type]
        self._held.append((labels, numbers))  # type: ignore[arg-type]

    @property
    def name_tendons(self) -> bool:
        """Whether a row names a tendon."""
        return any(labels[6] is not None for labels, _ in self._held)

    def __len__(self) -> int:
        return len(self._held)

    @overload
    def __getitem__(self, at: int) -> ThetaRow: ...
    @overload
    def __getitem__(self, at: slice) -> Sequence[ThetaRow]: ...
    def __getitem__(self, at: int | slice) -> ThetaRow | Sequence[ThetaRow]:
        return [_row(*held) for held in self._held[at]] if isinstance(at, slice) else _row(*self._held[at])

    def told(self, most: int) -> tuple[list[ThetaRow], int]:
        """Return the rows for a document, and how many without a line it leaves out: those beyond the first ``most`` of them."""
        found: list[ThetaRow] = []
        none = 0
        for labels, numbers in self._held:
            empty = all(v is None for v, n in zip(numbers, NUMBERS, strict=True) if n != "loops")
            none += empty
            if not empty or none <= most:
                found.append(_row(labels, numbers))
        return found, max(none - most, 0)

    def statuses(self) -> Iterator[tuple[str, str]]:
        """Yield run and status of every row."""
        return ((labels[0], labels[5]) for labels, _ in self._held)

    def seen(self) -> set[str]:
        """Return the runs that show a slope."""
        at = NUMBERS.index("gamma_p"), NUMBERS.index("gamma_r")
        return {labels[0] for labels, numbers in self._held if any(numbers[i] is not None for i in at)}

    def nulled(self, why: dict[str, str]) -> ThetaRows:
        """Return the rows with those of some runs without a number, and the reason in their status."""
        found = ThetaRows()
        for labels, numbers in self._held:
            if (said := why.get(labels[0])) is not None:
                labels = (*labels[:5], said, labels[6])
                numbers = tuple(v if n == "loops" else None for n, v in zip(NUMBERS, numbers, strict=True))
            found._held.append((labels, numbers))
        return found

    def table(self) -> pa.Table:
        """Return the Theta table; it has a column ``tendon`` if a row names one."""
        schema = pa.schema([*THETA.arrow(), *([pa.field(TENDON.name, TENDON.type)] if self.name_tendons else [])])
        parts = [_table(self._held[a : a + AT_ONCE], schema) for a in range(0, len(self._held), AT_ONCE)]
        return pa.concat_tables(parts) if parts else schema.empty_table()


def row_of(values: Mapping[str, str | float | None]) -> ThetaRow:
    """Return one row, given by its fields."""
    # a tendon that was not named stays away, as in the documents
    return ThetaRow.model_validate({n: values[n] for n in NAMES if n != "tendon" or values[n] is not None})


def _row(labels: Labels, numbers: Numbers) -> ThetaRow:
    return row_of({**dict(zip(LABELS, labels, strict=True)), **dict(zip(NUMBERS, numbers, strict=True))})


def _table(held: Sequence[tuple[Labels, Numbers]], schema: pa.Schema) -> pa.Table:
    labels = zip(*(labels for labels, _ in held), strict=True)
    numbers = zip(*(numbers for _, numbers in held), strict=True)
    columns = {**dict(zip(LABELS, labels, strict=True)), **dict(zip(NUMBERS, numbers, strict=True))}
    return pa.Table.from_arrays([pa.array(columns[f.name], f.type) for f in schema], schema=schema)

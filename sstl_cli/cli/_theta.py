"""Reading Theta tables for ``train`` and ``evaluate``, and saying what they set aside."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    import pyarrow as pa

    from sstl_cli.core.documents.mapping import AsideRow
    from sstl_cli.mapping.pairs import Pairs

SHOWN = 10


def read(paths: list[Path]) -> pa.Table:
    """Return the rows of all Theta tables as one Arrow table; a column one of them lacks is null there."""
    import pyarrow as pa

    from sstl_cli.core.errors import SstlError, UsageError
    from sstl_cli.core.parquet import open_table
    from sstl_cli.core.tables import TENDON, THETA

    if len({p.resolve() for p in paths}) != len(paths):
        raise UsageError("a file is given twice", where="THETA", fix="name each file once", code="E509")
    wanted = [*THETA.names, TENDON.name]
    pieces = []
    for path in paths:
        table = open_table(path, THETA).table()
        table = table.select([n for n in wanted if n in table.column_names]).replace_schema_metadata(None)
        if TENDON.name in table.column_names:
            at = table.column_names.index(TENDON.name)
            try:
                table = table.set_column(at, TENDON.name, table.column(at).cast(TENDON.type))
            except pa.ArrowException:
                kind = table.column(at).type
                raise SstlError(
                    f"column 'tendon' holds {kind}, not string", where=str(path), fix="segment the log again", code="E135"
                ) from None
        pieces.append(table)
    return pa.concat_tables(pieces, promote_options="permissive")


def note_aside(screen: Screen, pairs: Pairs) -> None:
    """Say on standard error how many rows were set aside, and why."""
    if pairs.aside:
        told = [f"{run}: {why}" for run, why in pairs.aside.items()]
        screen.note_some(f"{len(told)} of {pairs.rows} rows set aside:", told, SHOWN)


def aside_rows(pairs: Pairs) -> list[AsideRow]:
    """Return the same for a JSON document."""
    from sstl_cli.core.documents.mapping import AsideRow

    return [AsideRow(run_id=run, why=why) for run, why in pairs.aside.items()]

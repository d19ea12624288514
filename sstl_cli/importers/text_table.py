"""A log written as CSV (``sstl export``), read block by block as it stands, for ``info`` and ``check``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyarrow as pa


class TextTable:
    """Looks like a table reader; nothing is repaired, so that what is wrong with the file is seen.

    Raises
    ------
    SstlError
        If the file is no text table, or has none of the log's columns.
    """

    def __init__(self, path: Path) -> None:
        import pyarrow as pa

        from sstl_cli.core.errors import SstlError
        from sstl_cli.core.tables import LOG, TENDON
        from sstl_cli.importers import text
        from sstl_cli.importers.base import Layout

        self.path, self._layout = path, Layout()
        self.metadata: dict[str, object] = {}
        known = {c.name: c for c in (*LOG.columns, TENDON)}
        try:
            stated = {c.name: c.unit for c in text.channels(path, self._layout)}
        except SstlError as error:
            raise SstlError(
                f"is text that holds no table ({error.what})",
                where=str(path),
                fix=f"give a log; sstl import --guess {path.name} looks at recordings",
                code=error.code,
            ) from None
        for name in known:
            text.require_once(name, stated, str(path))
        self.fields = [known[n] for n in stated if n in known]
        if not self.fields:
            raise SstlError(
                f"has none of the log's columns ({', '.join(list(stated)[:6])})",
                where=str(path),
                fix=f"sstl import --guess {path.name} proposes a mapping",
                code="E134",
            )
        units = [{"unit": stated[c.name] or c.unit} for c in self.fields]
        self.schema_arrow = pa.schema([pa.field(c.name, c.type, True, u) for c, u in zip(self.fields, units, strict=True)])
        self.file = SimpleNamespace(schema_arrow=self.schema_arrow, iter_batches=self.iter_batches)

    @property
    def rows(self) -> int:
        """Number of lines below the header (blank ones included)."""
        from sstl_cli.importers.text_file import opened
        from sstl_cli.importers.text_layout import layout_of

        layout = layout_of(self.path, self._layout)
        lines, last = 0, b""
        with opened(self.path) as file:
            file.seek(layout.first_byte)
            while block := file.read(1 << 22):
                lines, last = lines + block.count(layout.line_end), block[-1:]
        return lines + (last not in (b"", b"\n", b"\r"))

    def iter_batches(self, rows: int, columns: list[str] | None = None) -> Iterator[pa.RecordBatch]:
        """Yield the wanted columns (default all) as Arrow batches of at most ``rows`` rows."""
        import pyarrow as pa

        from sstl_cli.importers import text
        from sstl_cli.importers.base import Notes

        wanted = [c for c in self.fields if columns is None or c.name in columns]
        numbers = [c.name for c in wanted if c.type == pa.float64()]
        labels = [c.name for c in wanted if c.name not in numbers]
        for block in text.read(self.path, numbers, labels, self._layout, Notes()):
            arrays: list[Any] = [
                pa.array(block.columns[c.name], from_pandas=c.nullable) if c.name in numbers else block.columns[c.name] for c in wanted
            ]
            batch = pa.RecordBatch.from_arrays(arrays, names=[c.name for c in wanted])
            for start in range(0, batch.num_rows, rows):
                yield batch.slice(start, rows)

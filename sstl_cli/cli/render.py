"""The one renderer: tables and sentences for people on stdout, or one JSON document."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn, TypeVar

import typer

from sstl_cli.cli.streams import takes_all_text
from sstl_cli.core.errors import SstlError, printable

T = TypeVar("T")
SHOW_PROGRESS_AFTER_S = 2.0
PIPE_COLUMNS = 200
# the screens of this call of the program
_open: list[Screen] = []


class Screen:
    """What one command shows: results on stdout, narration and progress on stderr.

    With ``lines`` it prints JSON Lines: several documents, one a line.
    """

    def __init__(self, as_json: bool = False, lines: bool = False) -> None:
        self.as_json, self.lines = as_json, lines
        self.shown = False
        _open.append(self)

    def note(self, text: str) -> None:
        """Print narration on stderr."""
        print(printable(text), file=sys.stderr)

    def line(self, text: str = "") -> None:
        """Print a line of the result (not with --json)."""
        if not self.as_json:
            print(printable(text))

    def table(self, title: str, header: Sequence[str], rows: Iterable[Sequence[object]], notes: str = "") -> None:
        """Print a table that fits 80 columns where it can; numbers to the right (not with --json)."""
        if self.as_json:
            return
        from rich import box
        from rich.console import Console
        from rich.table import Table
        from rich.text import Text

        rows = [list(r) for r in rows]
        table = Table(
            title=Text(title), box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), title_justify="left", title_style="bold"
        )
        for i, name in enumerate(header):
            numeric = all(isinstance(r[i], (int, float)) or r[i] is None for r in rows) if rows else False
            # half a number is a wrong number: only text is folded
            table.add_column(
                Text(name), justify="right" if numeric else "left", overflow="fold", no_wrap=numeric, min_width=4
            )
        for row in rows:
            table.add_row(*(Text(printable(cell(v))) for v in row))
        # a file or a pipe has no width to keep to
        width = None if sys.stdout.isatty() or "COLUMNS" in os.environ else PIPE_COLUMNS
        Console(width=width, soft_wrap=False, highlight=False).print(table)
        if notes:
            self.line(notes)

    def document(self, document: dict[str, Any]) -> None:
        """Print a JSON document, if asked for."""
        if self.as_json:
            from sstl_cli.core.files import dumps

            print(dumps(document, ascii_only=not takes_all_text(), one_line=self.lines))
            self.shown = True

    def finish(self, document: dict[str, Any], code: int = 0) -> NoReturn:
        """Print the JSON document if asked for, and end with the exit code."""
        self.document(document)
        raise typer.Exit(code)

    @contextmanager
    def progress(self, label: str, total: float | None = None) -> Iterator[Callable[[float], None]]:
        """Yield ``advance(amount)``; a bar appears on stderr once the work takes over two seconds."""
        started = time.monotonic()
        bar: list[Any] = []
        done = 0.0

        def advance(amount: float) -> None:
            nonlocal done
            done += amount
            if not bar and sys.stderr.isatty() and time.monotonic() - started > SHOW_PROGRESS_AFTER_S:
                bar.append(_bar(label, total))
            if bar:
                bar[0].update(0, completed=done)

        try:
            yield advance
        finally:
            if bar:
                bar[0].stop()


def begin() -> None:
    """Forget the screens of an earlier call in this process."""
    _open.clear()


def show_error(error: SstlError) -> None:
    """Print a failure as a JSON document, if the call asked for JSON and has not printed its document yet."""
    if _open:
        wanted = any(s.as_json and (s.lines or not s.shown) for s in _open)
    else:
        # the command did not come to its screen: a wrong option beside --json, for example
        words = sys.argv[1:]
        wanted = "--json" in (words[: words.index("--")] if "--" in words else words)
    if not wanted:
        return
    from sstl_cli.core.documents.error import of
    from sstl_cli.core.files import dumps

    with contextlib.suppress(OSError):
        print(dumps(of(error).model_dump(by_alias=True), ascii_only=not takes_all_text(), one_line=True), flush=True)


def track(screen: Screen, label: str, items: Sequence[T]) -> Iterator[T]:
    """Yield items while a progress bar follows."""
    with screen.progress(label, len(items)) as advance:
        for item in items:
            yield item
            advance(1)


def cell(value: object) -> str:
    """Return a table cell: four significant digits for floats, a dash for null."""
    if value is None or value != value:
        return "-"
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value)


def _bar(label: str, total: float | None) -> Any:
    from rich.console import Console
    from rich.progress import Progress

    bar = Progress(console=Console(stderr=True), transient=True)
    bar.add_task(label, total=total)
    bar.start()
    return bar

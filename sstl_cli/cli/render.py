"""The one renderer: tables and sentences for people on stdout, or one JSON document."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING, NoReturn, TextIO, TypeVar

import typer

from sstl_cli.cli._progress import Bar, Pace
from sstl_cli.cli.streams import takes_all_text, tell
from sstl_cli.core.aside import open_ledger
from sstl_cli.core.errors import EXIT_DONE, EXIT_GATE, EXIT_SET_ASIDE, GateError, SstlError, printable

if TYPE_CHECKING:
    # pydantic is not imported for a call that shows no document
    from sstl_cli.core.aside import Ledger
    from sstl_cli.core.documents.base import Document

    # a document is shown as its fields, a class of documents as its JSON Schema
    Shown = Document | type[Document]

T = TypeVar("T")
PIPE_COLUMNS = 200
SHOWN_ASIDE = 20
# what a command itself set aside is told item by item up to here
MOST_TOLD = 50
# the screens of this call of the program, what its -q and -v ask for, and when it began
_open: list[Screen] = []
_asked: set[str] = set()
_began = time.monotonic()


class Screen:
    """What one command shows: results on stdout, narration and progress on stderr.

    With ``lines`` it prints JSON Lines: several documents, one a line.
    """

    def __init__(self, as_json: bool = False, lines: bool = False) -> None:
        self.as_json, self.lines = as_json, lines
        self.shown = False
        # from here on, whatever the reading of logs sets aside is noted here
        self.aside = open_ledger()
        _open.append(self)

    def note(self, text: str) -> None:
        """Print narration on stderr, broken between words where the terminal ends (not with --quiet)."""
        if "quiet" not in _asked:
            for line in _broken(printable(text), width_of(sys.stderr)):
                # what is worked on matters more than what is said of it: a full disk under the narration ends nothing
                tell(line)

    def note_some(self, title: str, lines: Sequence[str], most: int, more: int = 0) -> None:
        """Print narration with a list below it, of at most so many lines; ``more`` are not in the list."""
        for text in (title, *(f"  {line}" for line in lines[:most])):
            self.note(text)
        if (others := len(lines[most:]) + more) > 0:
            self.note(f"  and {others} more")

    def line(self, text: str = "") -> None:
        """Print a line of the result (not with --json)."""
        if not self.as_json:
            print(printable(text))

    def say(self, text: str) -> None:
        """Print a sentence of the result, broken between words where the terminal ends (not with --json)."""
        for line in _broken(printable(text), width_of(sys.stdout)):
            self.line(line)

    def table(
        self,
        title: str,
        header: Sequence[str],
        rows: Iterable[Sequence[object]],
        notes: str = "",
        most: int | None = None,
        more: int = 0,
        whole: str = "--json",
    ) -> None:
        """Print a table in the width of the terminal (not with --json): numbers to the right, at most ``most`` rows.

        ``more`` rows are not among those given, and ``whole`` has all of them.
        """
        if self.as_json:
            return
        from sstl_cli.cli import _table

        rows = [list(r) for r in rows]
        cells = [[printable(cell(v)) for v in row] for row in rows[:most]]
        numeric = [bool(rows) and all(_is_number(r[i]) for r in rows) for i in range(len(header))]
        if title:
            print(f"\n{_bold(printable(title))}")
        for line in _table.lines(header, cells, numeric, width_of(sys.stdout)):
            print(line)
        if (others := len(rows) - len(cells) + more) > 0:
            self.line(f"and {others} more rows; {whole} has all")
        if notes:
            self.say(notes)

    def document(self, document: Shown) -> None:
        """Print a JSON document, if asked for."""
        if self.as_json:
            from sstl_cli.core.files import dumps

            plain = document.json_schema() if isinstance(document, type) else document.plain()
            print(dumps(plain, ascii_only=not takes_all_text(), one_line=self.lines))
            self.shown = True

    def finish(
        self,
        document: Shown,
        code: int = EXIT_DONE,
        *,
        missed: Sequence[str] = (),
        aside: Collection[str] | bool = (),
        gate: GateError | None = None,
    ) -> NoReturn:
        """Print the JSON document if asked for, and end with the exit code: the one place that decides it.

        Parameters
        ----------
        code : int
            The exit code where a step has decided it, such as 1 for a failure that was found.
        missed : sequence of str
            Gates that were missed (4), told here.
        aside : collection of str, or bool
            What was set aside (3), told here; or whether anything was that has been told.
        gate : GateError, optional
            A gate that was missed, ending the call as its error.
        """
        for text in missed:
            self.note(f"gate missed: {text}")
        told = [] if isinstance(aside, bool) else list(aside)
        for text in told[:MOST_TOLD]:
            self.note(f"set aside: {text}")
        if len(told) > MOST_TOLD:
            self.note(f"set aside: and {len(told) - MOST_TOLD} more")
        entries = self.aside.entries
        for entry in entries[:SHOWN_ASIDE]:
            self.note(f"set aside: {entry}")
        if len(entries) > SHOWN_ASIDE:
            lost = sum(e.samples for e in entries[SHOWN_ASIDE:]) + self.aside.more_samples
            self.note(f"set aside: and {len(entries) - SHOWN_ASIDE + self.aside.more} more, {lost} samples")
        self.document(_with_aside(document, self.aside))
        if "verbose" in _asked:
            self.note(f"took {time.monotonic() - _began:.1f} s{_memory()}")
        if gate is not None:
            raise gate
        raise typer.Exit(EXIT_GATE if missed else code or (EXIT_SET_ASIDE if aside or entries else EXIT_DONE))

    def note_versions(self, version: object, what: str) -> None:
        """Say on standard error that what the call reads was made by another version of the program."""
        from sstl_cli.core.provenance import by_another

        for text in by_another(version, what):
            self.note(f"note: {text}")

    @contextmanager
    def progress(self, label: str, total: float | None = None, pace: Pace | None = None) -> Iterator[Callable[[float], None]]:
        """Yield ``advance(amount)``; a bar appears on stderr once the work takes over two seconds.

        With a ``pace`` it moves with the time that such work takes, not with its steps.
        """
        if "quiet" in _asked or not sys.stderr.isatty():
            yield lambda _: None
            return
        bar = Bar(label, total, pace)
        try:
            yield bar.advance
        finally:
            bar.close()


def _with_aside(document: Shown, book: Ledger) -> Shown:
    """Return a document with what the reading of logs set aside, where it did."""
    if not book.entries or isinstance(document, type):
        return document
    from sstl_cli.core.documents.base import DataSetAside

    told: dict[str, object] = {"data_set_aside": [DataSetAside(**asdict(e)) for e in book.entries]}
    return document.model_copy(update=told | ({"data_set_aside_more": book.more} if book.more else {}))


def begin() -> None:
    """Forget the screens of an earlier call in this process."""
    _open.clear()
    _asked.clear()


def narrate(how: str) -> None:
    """Take note that the call asks to be ``quiet`` or ``verbose``."""
    _asked.add(how)


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
        print(dumps(of(error).plain(), ascii_only=not takes_all_text(), one_line=True), flush=True)


def track(screen: Screen, label: str, items: Sequence[T]) -> Iterator[T]:
    """Yield items while a progress bar follows."""
    with screen.progress(label, len(items)) as advance:
        for item in items:
            yield item
            advance(1)


def many(count: int, noun: str) -> str:
    """Return a count with its noun.

    Examples
    --------
    >>> many(1, "run"), many(0, "run")
    ('1 run', '0 runs')
    """
    return f"{count} {noun}" + ("" if count == 1 else "s")


def _is_number(value: object) -> bool:
    return value is None or isinstance(value, (int, float)) or (isinstance(value, str) and value.startswith("< "))


def _memory() -> str:
    """Return the most memory the process held, where the system tells it."""
    try:
        import resource
    except ImportError:
        return ""
    # kilobytes, but bytes on macOS
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10)
    return f", {most:.0f} MB at most"


def _bold(text: str) -> str:
    plain = not sys.stdout.isatty() or "NO_COLOR" in os.environ or os.environ.get("TERM") == "dumb"
    return text if plain else f"\033[1m{text}\033[0m"


def width_of(stream: TextIO) -> int:
    """Return the columns to keep to; a file or a pipe has none."""
    import shutil

    return shutil.get_terminal_size().columns if stream.isatty() or "COLUMNS" in os.environ else PIPE_COLUMNS


def _broken(text: str, width: int) -> list[str]:
    """Return a text as lines; what continues an indented line stands further in than what follows it."""
    import re
    import textwrap

    if len(text) <= width:
        return [text]
    indent = text[: len(text) - len(text.lstrip())]
    # a number stays with its unit
    whole = re.sub(r"(?<=\d) (?=(?:m?N|m?s|Hz|mm)\b|%)", "\N{NO-BREAK SPACE}", text)
    lines = textwrap.wrap(whole, width, subsequent_indent=indent * 2, break_long_words=False, break_on_hyphens=False)
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def cell(value: object) -> str:
    """Return a table cell: four significant digits for floats, a dash for null."""
    if value is None or value != value:
        return "-"
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value)

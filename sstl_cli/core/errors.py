"""Errors that reach a user as one line: what went wrong, where, and what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

EXIT_DONE = 0
EXIT_FAILED = 1
EXIT_USAGE = 2
EXIT_SET_ASIDE = 3
EXIT_GATE = 4
# longer ones are values or arguments, not names of files
LONGEST_WORD = 400
LONGEST_TEXT = 3000


class SstlError(Exception):
    """A failure with one clear line for the user.

    Parameters
    ----------
    what : str
        What went wrong, in a few words.
    where : str, optional
        File, run, column or option concerned.
    fix : str, optional
        What the user can do about it.
    code : str, optional
        Short stable code, documented in docs/errors.md.
    """

    exit_code = EXIT_FAILED

    def __init__(self, what: str, *, where: str = "", fix: str = "", code: str = "E000") -> None:
        self.what, self.where, self.fix, self.code = what, where, fix, code
        super().__init__(self.line())

    def line(self) -> str:
        """Return the error as one line of text without control characters, long values cut."""
        text = f"{self.where}: {self.what}" if self.where else self.what
        if self.fix:
            text += f"; {self.fix}"
        return f"[{self.code}] {shown(text)}"


class UsageError(SstlError):
    """A wrong option or argument (exit code 2)."""

    exit_code = EXIT_USAGE


class GateError(SstlError):
    """A gate such as ``--max-rmse`` was missed (exit code 4)."""

    exit_code = EXIT_GATE


def printable(text: str) -> str:
    """Return text with control characters escaped, safe to print on a terminal."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shown(text: str) -> str:
    """Return text as an error shows it: printable, with what is too long to read cut."""
    return cut(printable(text))


def cut(text: str) -> str:
    """Return text whose long words, and itself if it is long, have lost their middle and say how much that was.

    Examples
    --------
    >>> len(cut("'" + 60_000 * "x" + "' is no number"))
    294
    """
    words = " ".join(_without_middle(word, LONGEST_WORD, 200, 50) for word in text.split(" "))
    return _without_middle(words, LONGEST_TEXT, 2000, 200)


def _without_middle(text: str, longest: int, head: int, tail: int) -> str:
    if len(text) <= longest:
        return text
    return f"{text[:head]}... ({len(text) - head - tail} more characters) ...{text[-tail:]}"


def nearest(name: str, names: Iterable[str]) -> str:
    """Return ``did you mean 'x'?`` for the closest of ``names``, or a list of them."""
    known = sorted(names)
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    if close:
        return f"did you mean '{close[0]}'?"
    shown = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    return f"known: {shown}"

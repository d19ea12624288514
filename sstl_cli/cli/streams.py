"""Standard output and error of the program: any encoding, closed, or on a full disk."""

from __future__ import annotations

import codecs
import contextlib
import os
import sys
from typing import TextIO

# what the program itself writes beyond ASCII, for streams that lack it
PLAIN = {"─": "-", "–": "-", "±": "+-", "²": "^2", "→": "->", "Γ": "Gamma", "β": "beta", "Δ": "Delta", "µ": "u", "°": "deg"}
BRAILLE = range(0x2800, 0x2900)


def open_streams() -> None:
    """Let both streams take any text: what their encoding lacks is spelled out or escaped, and a closed one takes it all."""
    codecs.register_error("sstl.plain", _spelled_out)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="sstl.plain")


def _spelled_out(error: UnicodeError) -> tuple[str, int]:
    """Return what stands for text that a stream cannot hold, and where it ends: dots of a drawing are stars, the unknown is escaped."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    found = ""
    for c in error.object[error.start : error.end]:
        if ord(c) in BRAILLE:
            found += "*" if ord(c) > BRAILLE.start else " "
        else:
            found += PLAIN.get(c) or c.encode("ascii", "backslashreplace").decode()
    return found, error.end


def drop_output() -> None:
    """Send what is left of the output nowhere: it could not be written, and Python would try again at its end."""
    _drop(sys.stdout)


def _drop(stream: TextIO) -> None:
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def tell(line: str) -> None:
    """Print a line on standard error, if that can be written."""
    with contextlib.suppress(OSError):
        print(line, file=sys.stderr, flush=True)


def settle_errors() -> None:
    """Drop what standard error still holds and cannot write: Python would try again at its end, and end with a code of its own."""
    try:
        sys.stderr.flush()
    except (OSError, ValueError):
        _drop(sys.stderr)


def takes_all_text() -> bool:
    """Whether standard output can hold every character."""
    return (getattr(sys.stdout, "encoding", None) or "utf-8").lower().replace("_", "-") in ("utf-8", "utf8", "utf-16", "utf-32")

"""Files appear whole or not at all: temporary name, fsync, rename."""

from __future__ import annotations

import json
import os
import re
import secrets
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from sstl_cli.core.errors import SstlError, UsageError

# tables and lists in one another, in any file the program reads back
MAX_DEPTH = 32
_NAMED: ContextVar[dict[object, list[tuple[str, Path | None]]] | None] = ContextVar("named", default=None)

_UNSAFE = re.compile("[\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ud800-\udfff\ufeff]")


def require_writable(path: Path, force: bool) -> None:
    """Raise SstlError if ``path`` exists without ``force``, is no file to overwrite, or its folder cannot take one.

    With ``force`` only a regular file is overwritten, and none that the same call reads (see :func:`call`).
    """
    path = Path(path)
    if path.is_dir():
        raise SstlError("is a folder", where=str(path), fix="give a file name", code="E101")
    require_followed(path)
    _require_own(path)
    if path.exists() and not path.is_file():
        raise SstlError("is no regular file (a device or a pipe)", where=str(path), fix="give the name of a file", code="E108")
    if path.exists() and not force:
        raise SstlError("exists already", where=str(path), fix="use --force to overwrite", code="E102")
    folder = path.resolve().parent if path.is_symlink() else path.parent
    if not folder.is_dir():
        raise SstlError("folder does not exist", where=str(folder), fix="create it first", code="E103")
    if not os.access(folder, os.W_OK):
        raise SstlError("folder is read-only", where=str(folder), fix="choose another output path", code="E104")


def require_outputs(force: bool, *paths: Path | None) -> None:
    """Raise SstlError, before any work is done, if one of the outputs could not be written; None is one not asked for."""
    for path in paths:
        if path is not None:
            require_writable(path, force)


def require_followed(path: Path) -> None:
    """Raise SstlError if this is a link to nothing, UsageError if it is the ``-`` by which others mean the standard output."""
    if str(path) == "-":
        raise UsageError(
            "stands for no file: outputs are files, written whole or not at all", where="-", fix="give the name of a file", code="E115"
        )
    if path.is_symlink() and not path.exists():
        target = os.readlink(path)
        raise SstlError(f"is a link to '{target}', which is not there", where=str(path), fix="remove the link", code="E107")


def require_regular(path: Path | str) -> None:
    """Raise SstlError E114 if an input is a pipe or a device: opening one waits for a writer, and it cannot be read twice.

    Inputs are read twice: once for what they hold, once for the SHA-256 that outputs keep of them.
    """
    path = Path(path)
    if path.exists() and not path.is_file() and not path.is_dir():
        raise SstlError("is no regular file (a device or a pipe)", where=str(path), fix="write it to a file first", code="E114")


def make_folder(path: Path) -> None:
    """Make a folder for outputs, if it is not there.

    Raises
    ------
    SstlError
        E103 if its parent does not exist, or a file stands there; E104 where it cannot be made; E107 for a link to nothing.
    """
    require_followed(path)
    try:
        path.mkdir(exist_ok=True)
    except (FileNotFoundError, FileExistsError, NotADirectoryError):
        what = "is a file, not a folder" if path.exists() else "folder does not exist"
        raise SstlError(what, where=str(path if path.exists() else path.parent), fix="create it first", code="E103") from None
    except OSError as error:
        raise SstlError(f"folder cannot be made: {error.strerror}", where=str(path), fix="check rights", code="E104") from None


@contextmanager
def call(named: Mapping[str, object], outputs: Collection[str]) -> Iterator[None]:
    """Know the files one call names, by option, so that no output takes the place of one that another option names.

    Parameters
    ----------
    named : mapping of str to object
        Value of each option: a path, a text that may be one, or a list of these; anything else names no file.
    outputs : collection of str
        The options among them that name what the call writes.
    """
    files: dict[object, list[tuple[str, Path | None]]] = {}
    for option, value in named.items():
        for text in value if isinstance(value, (list, tuple)) else [value]:
            if isinstance(text, Path) or (isinstance(text, str) and _is_file(text)):
                # without a path of its own an option is an input, and no output has its place
                files.setdefault(_identity(text), []).append((option, Path(text) if option in outputs else None))
    token = _NAMED.set(files)
    try:
        yield
    finally:
        _NAMED.reset(token)


def keep_safe(paths: Iterable[Path], what: str) -> None:
    """Refuse these files, such as those inside a bag's folder, as outputs of the call."""
    named = _NAMED.get()
    if named is None:
        return
    for path in paths:
        named.setdefault(_identity(path), []).append((what, None))


def _require_own(path: Path) -> None:
    """Raise UsageError if another option, or the input, is the same file as this output."""
    named = (_NAMED.get() or {}).get(_identity(path), [])
    options = list(dict.fromkeys(option for option, _ in named))
    # named once, by an output and in these words, it is the output's own option
    if len(options) > 1 or (options and all(text != path for _, text in named)):
        raise UsageError(
            f"is the same file as {' and '.join(options)}", where=str(path), fix="give the output a file of its own", code="E109"
        )


def _is_file(text: str) -> bool:
    return 0 < len(text) < 4096 and "\0" not in text and os.path.isfile(text)


def _identity(path: str | Path) -> object:
    """Return what two names of one file share: links of both kinds and other spellings give the same."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return os.path.realpath(path)
    return (found.st_dev, found.st_ino)


@contextmanager
def atomic(path: Path, force: bool = False) -> Iterator[Path]:
    """Yield a temporary name beside ``path``; on success it is synced and takes the name.

    Raises
    ------
    SstlError
        If the output exists without ``force``, or the disk refuses the write.
    """
    path = Path(path)
    require_writable(path, force)
    # what a link points to is overwritten, the link stays
    path = path.resolve() if path.is_symlink() else path
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        yield temporary
        with open(temporary, "rb") as file:
            os.fsync(file.fileno())
        if force:
            os.replace(temporary, path)
        else:
            # link fails if another process made the file meanwhile; replace would silently win
            os.link(temporary, path)
            temporary.unlink()
    except FileExistsError:
        raise SstlError(
            "was written by another process meanwhile", where=str(path), fix="choose another name, or give --force", code="E105"
        ) from None
    except OSError as error:
        raise SstlError(
            f"cannot be written: {error.strerror or error}", where=str(path), fix="check space and rights", code="E106"
        ) from None
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str, force: bool = False) -> None:
    """Write text atomically (UTF-8)."""
    with atomic(path, force) as temporary:
        temporary.write_text(text, encoding="utf-8")


def dumps(document: Any, ascii_only: bool = False, one_line: bool = False) -> str:
    """Return canonical JSON: NaN and infinity become null, floats keep full precision, no raw control character."""
    text = json.dumps(_plain(document), indent=None if one_line else 2, allow_nan=False, ensure_ascii=ascii_only)
    # C1 controls, line separators, bidirectional marks and lone surrogates: JSON allows them, terminals obey them
    return _UNSAFE.sub(_escaped, text)


def _escaped(found: re.Match[str]) -> str:
    return json.dumps(found.group()).strip('"') if found.group() != "\x7f" else "\\u007f"


def write_json(path: Path, document: Any, force: bool = False) -> None:
    """Write a document as JSON atomically."""
    write_text(path, dumps(document) + "\n", force)


def read_json(path: Path, schema: str | None = None) -> Any:
    """Return a JSON document; SstlError where it is missing, malformed or of another schema."""
    require_regular(path)
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise SstlError(f"cannot be read: {error.strerror}", where=str(path), fix="check path and rights", code="E110") from None
    except (ValueError, RecursionError) as error:
        raise SstlError(f"is not valid JSON ({str(error)[:120]})", where=str(path), fix="make it again", code="E111") from None
    if deeper_than(document, MAX_DEPTH):
        raise SstlError(f"is nested deeper than {MAX_DEPTH} levels", where=str(path), fix="make it again", code="E111")
    if schema is not None and (not isinstance(document, dict) or document.get("schema") != schema):
        found = document.get("schema") if isinstance(document, dict) else type(document).__name__
        raise SstlError(f"holds {found!r}, not {schema!r}", where=str(path), fix="give a document of that kind", code="E112")
    return document


def deeper_than(document: Any, levels: int) -> bool:
    """Return whether tables and lists stand in one another deeper than so many levels (without recursion)."""
    here = [document]
    for _ in range(levels + 1):
        parts = [v for v in here if isinstance(v, (dict, list))]
        if not parts:
            return False
        here = [v for part in parts for v in (part.values() if isinstance(part, dict) else part)]
    return True


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and (value != value or value in (float("inf"), float("-inf"))):
        return None
    return value

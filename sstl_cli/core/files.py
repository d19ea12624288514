"""Files appear whole or not at all: temporary name, fsync, rename."""

from __future__ import annotations

import json
import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sstl_cli.core.errors import SstlError

_UNSAFE = re.compile("[\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ud800-\udfff\ufeff]")


def require_writable(path: Path, force: bool) -> None:
    """Raise SstlError if ``path`` exists without ``force``, or its folder cannot take a file."""
    if path.is_dir():
        raise SstlError("is a folder", where=str(path), fix="give a file name", code="E101")
    if path.exists() and not force:
        raise SstlError("exists already", where=str(path), fix="use --force to overwrite", code="E102")
    folder = path.parent
    if not folder.is_dir():
        raise SstlError("folder does not exist", where=str(folder), fix="create it first", code="E103")
    if not os.access(folder, os.W_OK):
        raise SstlError("folder is read-only", where=str(folder), fix="choose another output path", code="E104")


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
        raise SstlError("was written by another process meanwhile", where=str(path), code="E105") from None
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
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise SstlError(f"cannot be read: {error.strerror}", where=str(path), code="E110") from None
    except (ValueError, RecursionError) as error:
        raise SstlError(f"is not valid JSON ({str(error)[:120]})", where=str(path), code="E111") from None
    if schema is not None and (not isinstance(document, dict) or document.get("schema") != schema):
        found = document.get("schema") if isinstance(document, dict) else type(document).__name__
        raise SstlError(f"holds {found!r}, not {schema!r}", where=str(path), code="E112")
    return document


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

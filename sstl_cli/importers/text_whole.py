"""JSON as one value, an array of records or an object of columns, as records one a line, which a text log is read from."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path

# of JSON, which is turned into lines in memory
MAX_BYTES = 32 << 20
_SAMPLE = 4096
Object = dict[str, object]


def records_of(path: Path) -> bytes:
    """Return the records of a file of JSON as lines of UTF-8, single values beside them as comments above; nothing where it holds no such."""
    with open(path, "rb") as file:
        head = file.read(_SAMPLE).removeprefix(b"\xef\xbb\xbf").lstrip()
    size = path.stat().st_size
    if not _may_be_whole(head) or size > MAX_BYTES:
        return b""
    return _records(path, size, path.stat().st_mtime_ns)


def _may_be_whole(head: bytes) -> bool:
    """Return whether a file may begin as an array of records or an object of columns: a first line that is a record of its own is none."""
    if head[:1] == b"[":
        return head[1:].lstrip()[:1] == b"{"
    first, _, rest = head.partition(b"\n")
    if head[:1] != b"{" or head[1:].lstrip()[:1] != b'"':
        return False
    return not (first.rstrip(b" \t\r,").endswith(b"}") and rest.lstrip()[:1] == b"{")


@lru_cache(maxsize=1)
def _records(path: Path, size: int, changed: int) -> bytes:
    """Return the same of a file of this size, last changed then."""
    try:
        value: object = json.loads(path.read_bytes().decode("utf-8-sig"))
    except (ValueError, RecursionError):
        # what is damaged is said of the lines as they stand there
        return b""
    beside: Object = {}
    if isinstance(value, dict) and not any(map(_is_column, value.values())):
        # {"bend_deg": 30, "samples": [{...}, ...]}
        told = [v for v in value.values() if isinstance(v, dict) and not any(isinstance(x, (list, dict)) for x in v.values())]
        held = [v for v in value.values() if isinstance(v, (list, dict)) and v not in told]
        beside = {k: v for k, v in value.items() if not isinstance(v, (list, dict))} | {k: v for t in told for k, v in t.items()}
        value = held[0] if len(held) == 1 else None
    if isinstance(value, dict):
        value, more = _by_rows(value)
        beside |= more
    if not isinstance(value, list) or len(value) < 2 or not all(isinstance(x, dict) for x in value):
        return b""
    above = [f"# {k}: {v}".replace("\n", " ") for k, v in beside.items()]
    return "\n".join([*above, *(json.dumps(x, ensure_ascii=False) for x in value), ""]).encode()


def _is_column(value: object) -> bool:
    """Return whether a value holds readings: a list of single values, or single values by their rows (pandas)."""
    held = value if isinstance(value, list) else list(value.values()) if isinstance(value, dict) and all(map(str.isdigit, value)) else []
    return len(held) > 1 and not any(isinstance(v, (list, dict)) for v in held)


def _by_rows(columns: Object) -> tuple[list[Object] | None, Object]:
    """Return the rows of columns and the single values beside them; None where the columns are not of one length, or other things stand there."""
    beside = {k: v for k, v in columns.items() if not isinstance(v, (list, dict))}
    held = {k: v for k, v in columns.items() if isinstance(v, (list, dict))}
    rows = {tuple(v) if isinstance(v, dict) else len(v) for v in held.values()}
    if len(rows) != 1 or not all(map(_is_column, held.values())):
        return None, beside
    values = [list(v.values()) if isinstance(v, dict) else v for v in held.values()]
    return [dict(zip(held, row, strict=True)) for row in zip(*values, strict=True)], beside

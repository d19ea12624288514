"""What every log format declares, how formats are found, and the limits they keep."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np
import pyarrow as pa

from sstl_cli import importers
from sstl_cli.core.errors import SstlError, nearest

ROWS_PER_BLOCK = 262_144
HEAD_BYTES = 65_536
# A file may not declare more than this many times its own size: real compression of measured data stays far below.
MAX_EXPANSION = 400
MIN_EXPANDED_BYTES = 64 << 20
# Formats that cannot be read in slices are loaded whole up to this many bytes.
MAX_LOADED_BYTES = 2 << 30
MAX_CHANNELS = 10_000

Values: TypeAlias = np.ndarray | pa.Array


@dataclass(frozen=True)
class Channel:
    """One recorded signal: its name, number of values (None: unknown), unit, own time channel, and what the file calls it beside its name.

    ``stamps`` says that its numbers are times written as text, which are read in s.
    """

    name: str
    rows: int | None = None
    unit: str = ""
    time: str = ""
    text: bool = False
    label: str = ""
    stamps: bool = False


@dataclass
class Block:
    """Equally long pieces of the selected channels, and how far into the file they reach (bytes)."""

    columns: dict[str, Values]
    position: int = 0

    def __len__(self) -> int:
        return max((len(v) for v in self.columns.values()), default=0)


@dataclass(frozen=True)
class Layout:
    """How text files are cut into columns, and into blocks of one header; other formats ignore it."""

    skip_rows: int = 0
    delimiter: str | None = None
    header: bool | None = None
    decimal: str | None = None
    comment: str | None = None
    blocks: str | None = None
    block_lines: tuple[str, ...] = ()


@dataclass
class Notes:
    """What a reader had to set aside, in words and rows, and what the mapping told it to leave out."""

    set_aside: dict[str, int] = field(default_factory=dict)
    trimmed: int = 0

    def aside(self, reason: str, rows: int) -> None:
        """Count rows that were not used, by reason."""
        if rows:
            self.set_aside[reason] = self.set_aside.get(reason, 0) + rows


class Format(Protocol):
    """A module that reads one log format."""

    ID: str
    TITLE: str
    EXTENSIONS: tuple[str, ...]
    RANK: int

    def sniff(self, head: bytes, path: Path) -> bool:
        """Return whether the first bytes (or the name) are this format's."""
        ...

    def channels(self, path: Path, layout: Layout) -> list[Channel]:
        """Return the recorded signals in the order of the file."""
        ...

    def read(self, path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
        """Yield blocks of the named channels: numbers as float64, labels as strings."""
        ...


def formats() -> dict[str, Format]:
    """Return every importer by id: each module beside this one that declares ``ID`` and ``read``."""
    found: dict[str, Format] = {}
    for info in pkgutil.iter_modules(importers.__path__):
        module: Any = importlib.import_module(f"{importers.__name__}.{info.name}")
        if hasattr(module, "ID") and hasattr(module, "sniff") and hasattr(module, "read"):
            found[module.ID] = module
    return dict(sorted(found.items(), key=lambda item: (item[1].RANK, item[0])))


def detect(path: Path, wanted: str | None = None) -> Format:
    """Return the importer for a file: the one named, else by first bytes, else by extension.

    Raises
    ------
    SstlError
        If the file is missing, empty, or of no known format.
    """
    known = formats()
    if wanted is not None:
        if wanted not in known:
            raise SstlError(f"unknown format '{wanted}'", where="--format", fix=nearest(wanted, known), code="E303")
        head_of(path)
        return known[wanted]
    head = head_of(path)
    for candidate in known.values():
        if candidate.sniff(head, path):
            return candidate
    suffix = path.suffix.lower()
    expected = [f for f in known.values() if suffix in f.EXTENSIONS and f.ID != "text"]
    if expected:
        raise SstlError(
            f"is named like {expected[0].TITLE} but does not begin like one",
            where=str(path),
            fix="the file is damaged or misnamed; --format names another format",
            code="E304",
        )
    raise SstlError("is in no known format", where=str(path), fix=f"give --format, one of {', '.join(known)}", code="E305")


def require_recording(path: Path) -> None:
    """Raise SstlError E306 where there is neither a file nor a folder: a name that is wrong, not a recording that is bad."""
    if not path.is_dir() and not path.is_file():
        what = "is not a regular file (a device or a pipe)" if path.exists() else "file not found"
        raise SstlError(what, where=str(path), fix="give the path of a recording", code="E306")


def head_of(path: Path) -> bytes:
    """Return the first bytes of a file; SstlError where there are none."""
    try:
        require_recording(path)
        if path.is_dir():
            return b""
        with open(path, "rb") as file:
            head = file.read(HEAD_BYTES)
    except OSError as error:
        raise SstlError(f"cannot be read: {error.strerror}", where=str(path), code="E306") from None
    if not head.strip():
        raise SstlError("is empty", where=str(path), fix="give a file with samples", code="E307")
    return head


@contextmanager
def guarded(path: Path, title: str) -> Iterator[None]:
    """Turn whatever a format library raises on a damaged file into one clear line.

    Libraries answer damaged bytes with any exception type, so all of them are translated here.
    """
    try:
        yield
    except (SstlError, GeneratorExit):
        raise
    except MemoryError as error:
        raise SstlError(
            "asks for more memory than there is", where=str(path), fix="the file is damaged or too large", code="E311"
        ) from error
    except Exception as error:
        detail = " ".join(f"{type(error).__name__}: {error}".split())[:110]
        raise SstlError(
            f"is truncated, damaged, or not {title} ({detail})", where=str(path), fix="record or copy it again", code="E310"
        ) from error


def require_few(path: Path, count: int, what: str = "channels") -> None:
    """Refuse a file of more channels than are read: one that is left out would be missed by its name."""
    if count > MAX_CHANNELS:
        raise SstlError(
            f"holds more than {MAX_CHANNELS} {what}", where=str(path), fix="copy those of the recording into a file", code="E324"
        )


def check_declared(path: Path, declared: int, what: str, file_bytes: int | None = None, whole: bool = False) -> None:
    """Refuse a size that a header declares but the file cannot hold.

    Parameters
    ----------
    declared : int
        Bytes of the values that the header announces.
    what : str
        What announces them, for the message.
    file_bytes : int, optional
        Size of the file (default: asked from the disk).
    whole : bool
        True where the values must be loaded at once.
    """
    size = path.stat().st_size if file_bytes is None else file_bytes
    if declared < 0 or declared > max(MIN_EXPANDED_BYTES, MAX_EXPANSION * size):
        raise SstlError(
            f"{what} declares {declared:.3g} bytes in a file of {size} bytes",
            where=str(path),
            fix=f"damaged or hostile: at most {MAX_EXPANSION} times the file size is read",
            code="E312",
        )
    if whole and declared > MAX_LOADED_BYTES:
        raise SstlError(
            f"{what} holds {declared / 2**30:.1f} GiB, which this format cannot read in slices",
            where=str(path),
            fix=f"split it below {MAX_LOADED_BYTES >> 30} GiB, or give it as text, Parquet or HDF5",
            code="E313",
        )


def need(path: Path, module: str, extra: str) -> Any:
    """Return an optional library, or say which extra brings it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise SstlError(
            f"this format needs the library '{module.split('.')[0]}'", where=str(path), fix=f"pip install 'sstl-cli[{extra}]'", code="E308"
        ) from None


def slices(rows: int, columns: dict[str, Callable[[int, int], Values]], size: int, rows_each: int = ROWS_PER_BLOCK) -> Iterator[Block]:
    """Yield blocks cut from channels that can be sliced; ``size`` bytes are spread over them for progress."""
    for start in range(0, rows, rows_each):
        stop = min(start + rows_each, rows)
        yield Block({name: cut(start, stop) for name, cut in columns.items()}, int(size * stop / max(rows, 1)))


def same_length(path: Path, lengths: dict[str, int]) -> int:
    """Return the common number of values; SstlError where channels differ (single values repeat)."""
    longest = max(lengths.values(), default=0)
    for name, length in lengths.items():
        if length not in (longest, 1):
            first = next(n for n, v in lengths.items() if v == longest)
            raise SstlError(
                f"channel '{name}' has {length} values, '{first}' has {longest}",
                where=str(path),
                fix="give each its own time channel (time = ...) in the mapping",
                code="E314",
            )
    return longest


def text_array(values: Any) -> pa.Array:
    """Return values of any kind as Arrow strings; bytes are read as UTF-8, whole numbers lose the point."""
    out: list[str | None] = []
    for value in np.asarray(values).ravel().tolist() if not isinstance(values, list) else values:
        if value is None or (isinstance(value, float) and value != value):
            out.append(None)
        elif isinstance(value, bytes):
            out.append(value.decode("utf-8", "replace"))
        elif isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
            out.append(str(int(value)))
        else:
            out.append(str(value))
    return pa.array(out, pa.string())


def members(path: Path) -> list[Path]:
    """Return the files that make up an input: itself, or the regular files of a bag folder.

    Raises
    ------
    SstlError
        If a folder holds no storage file, or a link that leads out of it.
    """
    if not path.is_dir():
        return [path]
    found = sorted(p for p in path.iterdir() if p.suffix.lower() in (".db3", ".mcap", ".yaml"))
    storage = [p for p in found if p.suffix.lower() != ".yaml"]
    if not storage:
        raise SstlError(
            "is a folder without .db3 or .mcap files", where=str(path), fix="give recordings, or a ROS 2 bag folder", code="E306"
        )
    for member in found:
        if member.is_symlink() or not member.is_file():
            raise SstlError(f"'{member.name}' is a link or no regular file", where=str(path), fix="copy the file into the bag", code="E315")
    return found

"""NumPy archives (``.npz``) and single arrays (``.npy``); pickled objects are refused."""

from __future__ import annotations

import stat
import zipfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import IO, Any

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import (
    MAX_CHANNELS,
    Block,
    Channel,
    Layout,
    Notes,
    check_declared,
    guarded,
    same_length,
    slices,
    text_array,
)

ID = "npz"
TITLE = "a NumPy archive"
EXTENSIONS = (".npz", ".npy")
RANK = 30
MAX_HEADER_BYTES = 65_536
_MAGIC = b"\x93NUMPY"


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the file is a zip archive named or filled like NPZ, or one array."""
    return head.startswith(_MAGIC) or (
        head.startswith(b"PK\x03\x04") and (path.suffix.lower() == ".npz" or b".npy" in head[:512])
    )


def channels(path: Path, layout: Layout) -> list[Channel]:
    """Return the arrays and matrix columns (``name[2]``) and the fields of structured arrays (``name.field``)."""
    with guarded(path, TITLE):
        out = []
        for name, _, shape, kind in _members(path):
            if kind.names:
                out += [Channel(f"{name}.{f}", _rows(shape), text=kind[f].kind in "US") for f in kind.names]
            elif len(shape) == 2 and shape[1] > 1 and shape[0] > 1:
                out += [Channel(f"{name}[{i + 1}]", shape[0]) for i in range(min(shape[1], 512))]
            elif kind.kind in "biufUS":
                out.append(Channel(name, _rows(shape), text=kind.kind in "US"))
        return out[:MAX_CHANNELS]


def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
    """Yield blocks of the named arrays."""
    with guarded(path, TITLE):
        held: dict[str, Any] = {}
        wanted = list(dict.fromkeys([*numbers, *labels]))
        for name, member, _, kind in _members(path):
            mine = [w for w in wanted if w == name or w.startswith((name + ".", name + "["))]
            if not mine:
                continue
            array = _load(path, member)
            for full in mine:
                rest = full[len(name) :]
                if rest.startswith(".") and kind.names:
                    values = array[rest[1:]].ravel()
                elif rest.startswith("["):
                    values = array[:, int(rest[1:-1]) - 1]
                else:
                    values = array.ravel()
                if full in numbers and values.dtype.kind not in "biuf":
                    raise SstlError(
                        f"'{full}' holds text, not numbers", where=str(path), fix="map another array", code="E328"
                    )
                held[full] = text_array(values) if full in labels else values.astype(np.float64)
        rows = same_length(path, {n: len(v) for n, v in held.items()})
        columns: dict[str, Any] = {n: (lambda a, b, v=v: v[a:b] if len(v) > 1 else v) for n, v in held.items()}
        yield from slices(rows, columns, path.stat().st_size, path)


def _rows(shape: tuple[int, ...]) -> int:
    return int(np.prod(shape, dtype=object)) if shape else 1


def _members(path: Path) -> list[tuple[str, str | None, tuple[int, ...], np.dtype]]:
    """Return name, archive member, shape and type of every array, checked against the sizes that are there."""
    size = path.stat().st_size
    with open(path, "rb") as file:
        if file.read(6) == _MAGIC:
            file.seek(0)
            shape, kind, _ = _header(file, path, path.name)
            _check(path, path.name, shape, kind, size, size)
            return [(path.stem, None, shape, kind)]
    out: list[tuple[str, str | None, tuple[int, ...], np.dtype]] = []
    with zipfile.ZipFile(path) as archive:
        entries = archive.infolist()
        if len(entries) > MAX_CHANNELS:
            raise SstlError(
                f"has {len(entries)} members", where=str(path), fix=f"at most {MAX_CHANNELS} are read", code="E324"
            )
        check_declared(path, sum(e.file_size for e in entries), "the archive", size)
        for entry in entries:
            _check_name(entry, path)
            if not entry.filename.endswith(".npy"):
                continue
            check_declared(path, entry.file_size, f"member '{entry.filename}'", size, whole=True)
            with archive.open(entry) as file:
                shape, kind, _ = _header(file, path, entry.filename)
            _check(path, entry.filename, shape, kind, entry.file_size, size)
            out.append((entry.filename[:-4], entry.filename, shape, kind))
    return out


def _check_name(entry: zipfile.ZipInfo, path: Path) -> None:
    """Refuse names that lead out of the archive, and links; nothing is ever unpacked to disk."""
    name = PurePosixPath(entry.filename.replace("\\", "/"))
    if name.is_absolute() or ".." in name.parts or entry.filename[1:2] == ":":
        raise SstlError(
            f"member '{entry.filename}' leads out of the archive", where=str(path), fix="do not trust it", code="E315"
        )
    if stat.S_ISLNK(entry.external_attr >> 16):
        raise SstlError(f"member '{entry.filename}' is a link", where=str(path), fix="do not trust it", code="E315")
    if entry.flag_bits & 1:
        raise SstlError("is encrypted", where=str(path), fix="save it without a password", code="E310")


def _header(file: IO[bytes], path: Path, name: str) -> tuple[tuple[int, ...], np.dtype, bool]:
    head = file.read(10)
    if head[:6] != _MAGIC or len(head) < 10:
        raise ValueError(f"'{name}' is no array")
    long = head[6] >= 2
    length = int.from_bytes(head[8:10] + (file.read(2) if long else b""), "little")
    if length > MAX_HEADER_BYTES:
        raise ValueError(f"'{name}' has a header of {length} bytes")
    text = file.read(length)
    stream = BytesIO(text[:0] + length.to_bytes(4 if long else 2, "little") + text)
    reader = np.lib.format.read_array_header_2_0 if long else np.lib.format.read_array_header_1_0
    shape, fortran, kind = reader(stream)
    if kind.hasobject:
        raise SstlError(f"'{name}' holds pickled objects", where=str(path), fix="save plain arrays", code="E316")
    return shape, kind, fortran


def _check(path: Path, name: str, shape: tuple[int, ...], kind: np.dtype, stored: int, size: int) -> None:
    declared = _rows(shape) * max(kind.itemsize, 1)
    if declared < 0 or declared > stored or any(d < 0 for d in shape):
        raise SstlError(
            f"'{name}' declares {declared:.3g} bytes of values and stores {stored}",
            where=str(path),
            fix="the archive is damaged or hostile",
            code="E312",
        )


def _load(path: Path, member: str | None) -> np.ndarray:
    if member is None:
        return np.asarray(np.load(path, allow_pickle=False, mmap_mode="r"))
    with np.load(path, allow_pickle=False, max_header_size=MAX_HEADER_BYTES) as archive:
        return np.asarray(archive[member[:-4]])

"""NumPy archives (``.npz``) and single arrays (``.npy``); pickled objects are refused."""

from __future__ import annotations

import stat
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import IO, Any

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import (
    ROWS_PER_BLOCK,
    Block,
    Channel,
    Layout,
    Notes,
    Values,
    check_declared,
    guarded,
    require_few,
    same_length,
    text_array,
)
from sstl_cli.importers.told import told

ID = "npz"
TITLE = "a NumPy file (.npz or .npy)"
EXTENSIONS = (".npz", ".npy")
RANK = 30
MAX_HEADER_BYTES = 65_536
_MAGIC = b"\x93NUMPY"


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the file is a zip archive named or filled like NPZ, or one array."""
    return head.startswith(_MAGIC) or (head.startswith(b"PK\x03\x04") and (path.suffix.lower() == ".npz" or b".npy" in head[:512]))


@dataclass(frozen=True)
class Stored:
    """One array of the file: its name, archive member (None: the file itself), shape, type and order."""

    name: str
    member: str | None
    shape: tuple[int, ...]
    kind: np.dtype
    fortran: bool

    @property
    def rows(self) -> int:
        """Number of values of each of its channels."""
        return self.shape[0] if self.matrix else int(np.prod(self.shape, dtype=object)) if self.shape else 1

    @property
    def matrix(self) -> bool:
        """Whether its columns are the channels."""
        return not self.kind.names and len(self.shape) == 2 and self.shape[0] > 1 and self.shape[1] > 1


def channels(path: Path, layout: Layout) -> list[Channel]:
    """Return the arrays and matrix columns (``name[2]``) and the fields of structured arrays (``name.field``)."""
    with guarded(path, TITLE):
        out = []
        members = _members(path)
        for a in members:
            if a.kind.names:
                out += [Channel(f"{a.name}.{f}", a.rows, text=a.kind[f].kind in "US") for f in a.kind.names]
            elif a.matrix:
                out += [Channel(f"{a.name}[{i + 1}]", a.rows) for i in range(min(a.shape[1], 512))]
            elif a.kind.kind in "biufUS":
                out.append(Channel(a.name, a.rows, text=a.kind.kind in "US"))
        # names of the columns of a matrix; labels of each sample are as many as those
        few = [a for a in members if a.kind.kind in "US" and a.rows <= max((b.shape[1] for b in members if b.matrix), default=0)]
        beside = told([c.name for c in out if not c.text], {a.name: text_array(_load(path, a).ravel()).to_pylist() for a in few})
        out = [replace(c, label=beside[c.name][0], unit=beside[c.name][1]) if c.name in beside else c for c in out]
        require_few(path, len(out))
        return out


def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
    """Yield blocks of the named arrays; no array is held whole, but for matrices stored by columns."""
    wanted = list(dict.fromkeys([*numbers, *labels]))
    with guarded(path, TITLE), ExitStack() as stack:
        parts: list[tuple[Stored, list[str]]] = []
        for array in _members(path):
            mine = [w for w in wanted if w == array.name or w.startswith((array.name + ".", array.name + "["))]
            if mine:
                parts.append((array, mine))
        lengths = {w: array.rows for array, mine in parts for w in mine}
        rows = same_length(path, lengths)
        readers = [(array, mine, _rows_of(path, array, rows, stack)) for array, mine in parts]
        size = path.stat().st_size
        for start in range(0, rows, ROWS_PER_BLOCK):
            n = min(ROWS_PER_BLOCK, rows - start)
            columns: dict[str, Values] = {}
            for array, mine, take in readers:
                piece = take(n)
                for full in mine:
                    columns[full] = _column(path, array, piece, full, full in numbers)
            yield Block(columns, int(size * (start + n) / rows))


def _column(path: Path, array: Stored, piece: np.ndarray, full: str, number: bool) -> Any:
    rest = full[len(array.name) :]
    if rest.startswith(".") and array.kind.names:
        values = piece[rest[1:]].ravel()
    elif rest.startswith("["):
        values = piece[:, int(rest[1:-1]) - 1]
    else:
        values = piece.ravel()
    if number and values.dtype.kind not in "biuf":
        raise SstlError(f"'{full}' holds text, not numbers", where=str(path), fix="map another array", code="E328")
    return values.astype(np.float64) if number else text_array(values)


def _rows_of(path: Path, array: Stored, rows: int, stack: ExitStack) -> Callable[[int], np.ndarray]:
    """Return a function that gives the next rows of an array."""
    if array.member is None or (array.rows == 1 and rows > 1) or (array.fortran and array.matrix):
        whole = _load(path, array)
        if not array.matrix:
            whole = whole.ravel()
        if array.rows == 1 and rows > 1:
            return lambda n: whole
        done = 0

        def cut(n: int) -> np.ndarray:
            nonlocal done
            done += n
            return whole[done - n : done]

        return cut
    file = stack.enter_context(stack.enter_context(zipfile.ZipFile(path)).open(array.member))
    _header(file, path, array.member)
    width = array.shape[1] if array.matrix else 1

    def stream(n: int) -> np.ndarray:
        data = file.read(n * width * array.kind.itemsize)
        if len(data) < n * width * array.kind.itemsize:
            raise ValueError(f"'{array.member}' ends early")
        piece = np.frombuffer(data, array.kind)
        return piece.reshape(n, width) if array.matrix else piece

    return stream


def _size(shape: tuple[int, ...]) -> int:
    return int(np.prod(shape, dtype=object)) if shape else 1


def _members(path: Path) -> list[Stored]:
    """Return name, archive member, shape and type of every array, checked against the sizes that are there."""
    size = path.stat().st_size
    with open(path, "rb") as file:
        if file.read(6) == _MAGIC:
            file.seek(0)
            shape, kind, fortran = _header(file, path, path.name)
            _check(path, path.name, shape, kind, size)
            return [Stored(path.stem, None, shape, kind, fortran)]
    out: list[Stored] = []
    with zipfile.ZipFile(path) as archive:
        entries = archive.infolist()
        require_few(path, len(entries), "members")
        check_declared(path, sum(e.file_size for e in entries), "the archive", size)
        for entry in entries:
            _check_name(entry, path)
            if not entry.filename.endswith(".npy"):
                continue
            with archive.open(entry) as file:
                shape, kind, fortran = _header(file, path, entry.filename)
            _check(path, entry.filename, shape, kind, entry.file_size)
            out.append(Stored(entry.filename[:-4], entry.filename, shape, kind, fortran))
    return out


def _check_name(entry: zipfile.ZipInfo, path: Path) -> None:
    """Refuse names that lead out of the archive, and links; nothing is ever unpacked to disk."""
    name = PurePosixPath(entry.filename.replace("\\", "/"))
    if name.is_absolute() or ".." in name.parts or entry.filename[1:2] == ":":
        raise SstlError(f"member '{entry.filename}' leads out of the archive", where=str(path), fix="do not trust it", code="E315")
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


def _check(path: Path, name: str, shape: tuple[int, ...], kind: np.dtype, stored: int) -> None:
    declared = _size(shape) * max(kind.itemsize, 1)
    if declared < 0 or declared > stored or any(d < 0 for d in shape):
        raise SstlError(
            f"'{name}' declares {declared:.3g} bytes of values and stores {stored}",
            where=str(path),
            fix="the archive is damaged or hostile",
            code="E312",
        )


def _load(path: Path, array: Stored) -> np.ndarray:
    if array.member is None:
        return np.asarray(np.load(path, allow_pickle=False, mmap_mode="r"))
    check_declared(path, _size(array.shape) * array.kind.itemsize, f"member '{array.member}'", whole=True)
    with np.load(path, allow_pickle=False, max_header_size=MAX_HEADER_BYTES) as archive:
        return np.asarray(archive[array.name])

"""MATLAB files of version 5 to 7 (uncompressed or deflated): numeric vectors, strings, structs, cells of strings.

The container is walked here, not by a library: every declared size is held against the bytes that are there before
anything is allocated. A file of 0.9 MB that declares 1 GB of zeros is refused in 0.3 s (scipy's reader takes 1.2 GB and 4 s), and a
compressed variable is inflated in pieces (188 MiB for a struct of 192 MB; scipy 297 MiB). Source: MAT-File Format, The MathWorks, level 5.
"""

from __future__ import annotations

import tempfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import (
    MAX_CHANNELS,
    Block,
    Channel,
    Layout,
    Notes,
    Values,
    check_declared,
    guarded,
    require_few,
    same_length,
    slices,
    text_array,
)
from sstl_cli.importers.told import told

# number arrays and lists of texts by name
Vectors: TypeAlias = dict[str, np.ndarray | list[str]]
ID = "mat5"
TITLE = "a MATLAB file (v5 to v7)"
EXTENSIONS = (".mat",)
RANK = 20
MAX_DEPTH = 16
# compressed variables up to this size are inflated in memory
SPOOL_BYTES = 64 << 20
PIECE_BYTES = 8 << 20
MAX_ELEMENTS = 200_000
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_MATRIX, _COMPRESSED, _UTF8, _UTF16, _UTF32 = 14, 15, 16, 17, 18
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE = 1, 2, 3, 4, 5


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the file has the text header and the endian mark of level 5."""
    return len(head) >= 128 and head[126:128] in (b"IM", b"MI") and head[124:126] in (b"\x00\x01", b"\x01\x00")


def channels(path: Path, layout: Layout) -> list[Channel]:
    """Return vectors and matrix columns of all variables and struct fields (``a.b``, ``runs(2).time_s``, ``m[3]``)."""
    with guarded(path, TITLE):
        found = _vectors(path)
        texts = {n: v for n, v in found.items() if isinstance(v, list)}
        beside = told([n for n in found if n not in texts], texts)
        out = []
        for name, values in found.items():
            label, unit = beside.get(name, ("", ""))
            out.append(Channel(name, len(values), unit or _unit(name, found), text=name in texts, label=label))
        return out


def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
    """Yield blocks of the named channels."""
    with guarded(path, TITLE):
        found = _vectors(path)
        chosen = {n: found[n] for n in dict.fromkeys([*numbers, *labels])}
        rows = same_length(path, {n: len(v) for n, v in chosen.items()})
        columns: dict[str, Callable[[int, int], Values]] = {}
        for name, values in chosen.items():
            if name in numbers and isinstance(values, list):
                raise SstlError(f"'{name}' holds text, not numbers", where=str(path), fix="map another channel", code="E328")
            held = text_array(values) if name in labels else values
            columns[name] = _cut(held)
        yield from slices(rows, columns, path.stat().st_size)


def _unit(name: str, found: Vectors) -> str:
    """Return what a struct ``units`` of the file says of a field (empty where there is none)."""
    said = found.get(f"units.{name.rpartition('.')[2]}")
    return str(said[0]).strip() if isinstance(said, list) and len(said) == 1 and not name.startswith("units.") else ""


def _cut(held: Values) -> Callable[[int, int], Values]:
    """Return a function that gives rows of a channel; numbers are converted a piece at a time."""

    def rows(a: int, b: int) -> Values:
        piece = held[a:b] if len(held) > 1 else held
        return np.asarray(piece, np.float64) if isinstance(held, np.ndarray) else piece

    return rows


@dataclass
class _Walk:
    """Position-independent reader of elements with a budget of elements."""

    order: str
    path: Path
    elements: int = 0

    def tag(self, data: memoryview, at: int) -> tuple[int, int, int, int]:
        """Return type, length, start of the content and start of the next element."""
        self.elements += 1
        if self.elements > MAX_ELEMENTS:
            raise ValueError(f"more than {MAX_ELEMENTS} elements")
        if at + 8 > len(data):
            raise ValueError("ends inside an element")
        word = int(np.frombuffer(data[at : at + 4], self.order + "u4")[0])
        if word >> 16:
            kind, length, start, after = word & 0xFFFF, word >> 16, at + 4, at + 8
        else:
            length = int(np.frombuffer(data[at + 4 : at + 8], self.order + "u4")[0])
            kind, start = word, at + 8
            after = start + length + (0 if kind == _COMPRESSED else -length % 8)
        if (word >> 16 and length > 4) or start + length > len(data):
            raise ValueError(f"an element declares {length} bytes, {len(data) - start} are left")
        return kind, length, start, after

    def array(self, data: memoryview, at: int) -> tuple[np.ndarray, int]:
        """Return a numeric element and where the next one starts."""
        kind, length, start, after = self.tag(data, at)
        if kind == _UTF8:
            kind = 2
        elif kind == _UTF16:
            kind = 4
        elif kind == _UTF32:
            kind = 6
        if kind not in _NUMBERS:
            raise ValueError(f"unknown number type {kind}")
        kind_of = np.dtype(self.order + _NUMBERS[kind])
        if length % kind_of.itemsize:
            raise ValueError("a number element has a broken length")
        return np.frombuffer(data[start : start + length], kind_of), after

    def matrix(self, data: memoryview, depth: int = 0) -> tuple[str, Any]:
        """Return name and value of a matrix: ndarray, str, list (cell) or (dims, {field: values}) for a struct."""
        if depth > MAX_DEPTH:
            raise ValueError("structs are nested too deep")
        flags, at = self.array(data, 0)
        dims, at = self.array(data, at)
        raw, at = self.array(data, at)
        if len(flags) < 1 or len(dims) < 2 or (dims < 0).any():
            raise ValueError("a matrix has no valid dimensions")
        kind = int(flags[0]) & 0xFF
        count = 1
        for d in dims.tolist():
            count *= d
        name = raw.astype(np.uint8).tobytes().decode("latin-1")
        if count > max(len(data), 1) * 8 and count > 0:
            raise ValueError(f"'{name[:40]}' declares {count} values in {len(data)} bytes")
        if kind == _CELL:
            return name, self._items(data, at, count, depth)
        if kind in (_STRUCT, _OBJECT):
            if kind == _OBJECT:
                _, at = self.array(data, at)
            width, at = self.array(data, at)
            packed, at = self.array(data, at)
            size = int(width[0])
            if size < 1 or size > 128:
                raise ValueError("field names have a broken length")
            text = packed.astype(np.uint8).tobytes()
            fields = [text[i : i + size].split(b"\0")[0].decode("latin-1") for i in range(0, len(text), size)]
            items = self._items(data, at, count * len(fields), depth)
            return name, (count, {f: items[i :: len(fields)] for i, f in enumerate(fields)})
        if kind == _CHAR:
            codes, _ = self.array(data, at)
            if len(codes) != count:
                raise ValueError("a text has another length than declared")
            rows = codes.reshape(int(dims[0]), -1, order="F") if count else codes.reshape(0, 0)
            lines = ["".join(map(chr, row.tolist())).rstrip() for row in rows]
            return name, lines[0] if len(lines) == 1 else lines
        if 6 <= kind <= 15:
            values, _ = self.array(data, at)
            if len(values) != count:
                raise ValueError(f"'{name[:40]}' declares {count} values and holds {len(values)}")
            return name, values.reshape(dims.tolist(), order="F")
        return name, None

    def _items(self, data: memoryview, at: int, count: int, depth: int) -> list[Any]:
        if count * 8 > len(data) - at:
            raise ValueError(f"{count} cells are declared, {len(data) - at} bytes are left")
        out = []
        for _ in range(count):
            kind, length, start, at = self.tag(data, at)
            if kind != _MATRIX:
                raise ValueError("a cell holds no matrix")
            out.append(self.matrix(data[start : start + length], depth + 1)[1] if length else None)
        return out


def _vectors(path: Path) -> Vectors:
    """Return every vector of the file by name: number arrays, and lists of texts."""
    size = path.stat().st_size
    raw = np.memmap(path, np.uint8, "r")
    data = raw.data
    order = "<" if bytes(data[126:128]) == b"IM" else ">"
    walk = _Walk(order, path)
    out: Vectors = {}
    at, spent = 128, 0
    while at + 8 <= len(data):
        kind, length, start, at = walk.tag(data, at)
        body = data[start : start + length]
        if kind == _COMPRESSED:
            inner = _inflate(body, size, spent, order, path)
            spent += len(inner)
            kind, length, start, _ = walk.tag(inner, 0)
            body = inner[start : start + length]
        if kind == _MATRIX and length:
            name, value = walk.matrix(body)
            _flatten(name, value, out)
            require_few(path, len(out))
    if at < len(data) and len(data) - at >= 8:
        raise ValueError("ends inside an element")
    if not out:
        raise SstlError("holds no numeric vector", where=str(path), fix="save arrays or structs, not objects", code="E333")
    return out


def _inflate(body: memoryview, size: int, spent: int, order: str, path: Path) -> memoryview:
    """Return the deflated bytes of a variable, no more than its first tag declares and the limits allow.

    Large ones lie in an unnamed file, not in memory.
    """
    worker = zlib.decompressobj()
    at = PIECE_BYTES
    head = worker.decompress(bytes(body[:at]), 8)
    if len(head) < 8:
        raise ValueError("a compressed variable is cut off")
    declared = 8 + int(np.frombuffer(head[4:8], order + "u4")[0])
    check_declared(path, spent + declared, "a compressed variable", size)
    total = len(head)
    with tempfile.SpooledTemporaryFile(SPOOL_BYTES) as spool:
        spool.write(head)
        data = worker.unconsumed_tail
        while not worker.eof and (data or at < len(body)):
            if not data:
                data, at = bytes(body[at : at + PIECE_BYTES]), at + PIECE_BYTES
            piece = worker.decompress(data, PIECE_BYTES)
            data = worker.unconsumed_tail
            total += len(piece)
            if total > declared + 8:
                raise SstlError(
                    f"a compressed variable declares {declared} bytes and holds more",
                    where=str(path),
                    fix="damaged or hostile: save it again",
                    code="E312",
                )
            spool.write(piece)
        if not worker.eof:
            raise ValueError("a compressed variable is cut off")
        if total <= SPOOL_BYTES:
            spool.seek(0)
            return memoryview(spool.read())
        spool.flush()
        # the mapping keeps the file's bytes after its name and handle are gone
        return np.memmap(spool, np.uint8, "r").data


def _flatten(name: str, value: Any, out: Vectors) -> None:
    if len(out) > MAX_CHANNELS or value is None:
        return
    if isinstance(value, str):
        out[name] = [value]
    elif isinstance(value, list):
        if value and all(isinstance(v, str) for v in value):
            out[name] = value
        else:
            for i, item in enumerate(value[: MAX_CHANNELS + 1]):
                _flatten(f"{name}{{{i + 1}}}", item, out)
    elif isinstance(value, tuple):
        count, fields = value
        for i in range(min(count, MAX_CHANNELS + 1)):
            head = name if count == 1 else f"{name}({i + 1})"
            for field, items in fields.items():
                _flatten(f"{head}.{field}", items[i], out)
    elif (value.ndim == 2 and 1 in value.shape) or value.ndim == 1:
        if value.size:
            out[name] = value.ravel()
    elif value.ndim == 2:
        columns = value if value.shape[0] >= value.shape[1] else value.T
        for i in range(min(columns.shape[1], 512)):
            out[f"{name}[{i + 1}]"] = columns[:, i]

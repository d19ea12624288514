"""ROS messages decoded to flat numbers and texts: message definitions parsed here, no code generated.

Source: ROS 1 message wire format; OMG CDR little/big endian as written by ROS 2.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

MAX_VALUES = 256
MAX_DEPTH = 12
MAX_FIELDS = 4_000
_CODES = {
    "bool": "?",
    "byte": "b",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
_FIELD = re.compile(r"^([\w/]+)(<=\d+)?(\[(<=)?(\d*)\])?\s+(\w+)(\s+.*|\s*=.*)?$")
Flat = dict[str, Any]


@dataclass(frozen=True)
class Field:
    """One field: its name, base type, and array length (None: single, 0: any)."""

    name: str
    kind: str
    length: int | None


Definitions = dict[str, list[Field]]


def definitions(kind: str, text: str) -> Definitions:
    """Return the message types in a ``.msg`` definition with its dependencies behind ``MSG:`` lines."""
    out: Definitions = {}
    parts = re.split(r"^=+\s*$", text[: 1 << 20], flags=re.M)
    for i, part in enumerate(parts):
        name = short(kind)
        lines = part.strip().splitlines()
        if i or (lines and lines[0].startswith("MSG:")):
            if not lines or not lines[0].startswith("MSG:"):
                continue
            name, lines = short(lines[0][4:].strip()), lines[1:]
        fields = []
        for line in lines:
            line = line.split("#")[0].strip()
            found = _FIELD.match(line)
            if not found or (found[7] or "").lstrip().startswith("="):
                continue
            base = found[1]
            length = None if found[3] is None else 0 if found[4] or not found[5] else int(found[5])
            package = name.split("/")[0]
            if base not in _CODES and base not in ("string", "wstring", "time", "duration") and "/" not in base:
                base = "std_msgs/Header" if base == "Header" else f"{package}/{base}"
            fields.append(Field(found[6], short(base), length))
        out[name] = fields
    return out


def short(kind: str) -> str:
    """Return ``package/Type`` from ``package/msg/Type``."""
    return kind.replace("/msg/", "/")


def decoder(encoding: str, kind: str, known: Definitions) -> Callable[[bytes], Flat]:
    """Return a function from message bytes to flat values.

    Raises
    ------
    ValueError
        If the encoding is unknown or a type is not defined.
    """
    if encoding == "json":
        return lambda data: flatten(json.loads(data))
    if encoding not in ("cdr", "ros1"):
        raise ValueError(f"message encoding '{encoding}' is not supported (json, cdr and ros1 are)")
    if short(kind) not in known:
        raise ValueError(f"message type '{kind}' has no definition")
    return lambda data: _Reader(data, encoding == "cdr").message(short(kind), known)


def flatten(document: Any) -> Flat:
    """Return nested values as ``a.b[0]`` keys; only numbers, booleans and texts are kept."""
    out: Flat = {}
    stack: list[tuple[str, Any, int]] = [("", document, 0)]
    while stack:
        path, value, depth = stack.pop()
        if depth > MAX_DEPTH or len(out) > MAX_FIELDS:
            raise ValueError("a message is nested too deep or too wide")
        if isinstance(value, dict):
            stack += [(f"{path}.{k}" if path else str(k), v, depth + 1) for k, v in reversed(value.items())]
        elif isinstance(value, list):
            stack += [(f"{path}[{i}]", v, depth + 1) for i, v in reversed(list(enumerate(value[:MAX_VALUES])))]
        elif isinstance(value, (int, float, str)):
            out[path or "data"] = value
    return out


class _Reader:
    """Reads one serialised message; every read is held against the bytes that are left."""

    def __init__(self, data: bytes, cdr: bool) -> None:
        self.data, self.at, self.cdr, self.order, self.base = data, 0, cdr, "<", 0
        self.fields = 0
        if cdr:
            if len(data) < 4:
                raise ValueError("a message is shorter than its header")
            self.order, self.at, self.base = ("<" if data[1] & 1 else ">"), 4, 4

    def message(self, kind: str, known: Definitions, path: str = "", depth: int = 0, out: Flat | None = None) -> Flat:
        out = {} if out is None else out
        if depth > MAX_DEPTH:
            raise ValueError("messages are nested too deep")
        if kind not in known:
            raise ValueError(f"message type '{kind}' has no definition")
        for field in known[kind]:
            name = f"{path}.{field.name}" if path else field.name
            self._field(name, field, known, depth, out)
        if self.cdr and not known[kind]:
            self._number("B")
        return out

    def _field(self, name: str, field: Field, known: Definitions, depth: int, out: Flat) -> None:
        self.fields += 1
        if self.fields > MAX_FIELDS:
            raise ValueError("a message has too many fields")
        if field.length is None:
            self._value(name, field.kind, known, depth, out)
            return
        count = field.length or int(self._number("I"))
        if field.kind in _CODES:
            code = _CODES[field.kind]
            size = struct.calcsize("=" + code)
            if count:
                self._align(size)
            self._room(count * size)
            kept = min(count, MAX_VALUES)
            values = struct.unpack_from(f"{self.order}{kept}{code}", self.data, self.at)
            self.at += count * size
            out.update({f"{name}[{i}]": v for i, v in enumerate(values)})
            return
        self._room(count)
        for i in range(count):
            self._value(f"{name}[{i}]", field.kind, known, depth, out)
            self.fields += 1
            if self.fields > MAX_FIELDS:
                raise ValueError("a message has too many fields")

    def _value(self, name: str, kind: str, known: Definitions, depth: int, out: Flat) -> None:
        if kind in _CODES:
            out[name] = self._number(_CODES[kind])
        elif kind in ("string", "wstring"):
            length = int(self._number("I"))
            self._room(length)
            raw = self.data[self.at : self.at + length]
            self.at += length
            out[name] = raw.rstrip(b"\0").decode("utf-8", "replace")
        elif kind in ("time", "duration", "builtin_interfaces/Time", "builtin_interfaces/Duration"):
            seconds, nanoseconds = self._number("i"), self._number("I")
            out[name + "@ns"] = int(seconds) * 1_000_000_000 + int(nanoseconds)
        else:
            self.message(kind, known, name, depth + 1, out)

    def _number(self, code: str) -> Any:
        size = struct.calcsize("=" + code)
        self._align(size)
        self._room(size)
        (value,) = struct.unpack_from(self.order + code, self.data, self.at)
        self.at += size
        return value

    def _align(self, size: int) -> None:
        if self.cdr:
            self.at += -(self.at - self.base) % size

    def _room(self, size: int) -> None:
        if size > len(self.data) - self.at:
            raise ValueError(f"a message declares {size} bytes, {len(self.data) - self.at} are left")

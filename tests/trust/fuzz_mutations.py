"""Damage to files: of bytes, and of what a well-formed file says (JSON values, TOML lines, Parquet columns)."""

from __future__ import annotations

import copy
import io
import json
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from byte_damage import strike
from fuzz_seeds import join_model, seed_of, split_model, table_of

Rng = np.random.Generator
_WILD_BYTES = [
    b"\xff" * 8,
    b"\x00" * 8,
    b"\x7f\xff\xff\xff",
    b"1e999",
    b"[[[[[[[[",
    b'{"a":',
    b"nan",
    b"\n",
    b'"',
    b"-1",
    b"99999999999999",
]
_WILD: list[Any] = [
    None, True, -1, 0, 1, 10**30, -(2**63), 1e308, -1e-308, float("nan"), float("inf"), "", "x", "\x00", "\u202e\x1b[2J",
    "<script>", "=1+1", [], {}, [[]], [None], {"": None}, "é" * 500, [0] * 300, "1", "NaN",
]  # fmt: skip
_WILD_TOML = ["-1", "0", "nan", "inf", "1e308", '""', "[]", "{}", "true", '"x"', "[1, 2]", "99999999999999999999", "'''\n'''", "1979-05-27"]
TABLES = ("log", "theta", "phases", "reference")
JSONS = ("diagnosis", "controller")
TOMLS = ("scenario", "mapping", "config")


def mutated(kind: str, number: int) -> bytes:
    """Return input ``number`` of a kind, the same in every run; every other one stays well-formed."""
    rng = np.random.default_rng([number, *kind.encode()])
    if number % 2:
        return _bytes(bytearray(seed_of(kind)), rng)
    if kind in TABLES:
        return _table(table_of(kind), rng)
    if kind in JSONS:
        return _json(json.loads(seed_of(kind)), rng)
    if kind == "model":
        header, rest = split_model(seed_of(kind))
        return join_model(_json(header, rng), rest)
    return _toml(seed_of(kind).decode().splitlines(), rng)


def _bytes(data: bytearray, rng: Rng) -> bytes:
    for _ in range(int(rng.integers(1, 5))):
        if not data:
            break
        spot = int(rng.integers(0, len(data)))
        # headers and footers decide how the rest is read
        spot = (spot, spot % 300, max(0, len(data) - 1 - spot % 600))[int(rng.integers(0, 3))]
        length, how = int(rng.integers(1, 40)), int(rng.integers(0, 6))
        strike(data, spot, length, how, rng, _WILD_BYTES)
    return bytes(data)


def _places(node: Any, found: list[tuple[Any, Any]]) -> list[tuple[Any, Any]]:
    """Return every (container, key) of a document."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in list(items):
        found.append((node, key))
        _places(value, found)
    return found


def _json(document: Any, rng: Rng) -> bytes:
    for _ in range(int(rng.integers(1, 4))):
        places = _places(document, [])
        if not places:
            break
        node, key = places[int(rng.integers(0, len(places)))]
        how = int(rng.integers(0, 4))
        if how == 0:
            del node[key]
        elif how == 1:
            other, place = places[int(rng.integers(0, len(places)))]
            node[key] = copy.deepcopy(other[place])
        elif how == 2 and isinstance(node, dict):
            node[str(key) + "x"] = node.pop(key)
        else:
            node[key] = copy.deepcopy(_WILD[int(rng.integers(0, len(_WILD)))])
    return json.dumps(document).encode()


def _toml(lines: list[str], rng: Rng) -> bytes:
    for _ in range(int(rng.integers(1, 4))):
        if not lines:
            break
        i, how = int(rng.integers(0, len(lines))), int(rng.integers(0, 5))
        key, equals, value = lines[i].partition("=")
        if how == 0:
            del lines[i]
        elif how == 1:
            lines.insert(int(rng.integers(0, len(lines))), lines[i])
        elif how == 2 and equals:
            lines[i] = f"{key.strip()}x = {value}"
        elif how == 3 and lines[i].startswith("["):
            lines[i] = lines[i].replace("[", "[[").replace("]", "]]") if "[[" not in lines[i] else lines[i][1:-1]
        elif equals:
            lines[i] = f"{key} = {_WILD_TOML[int(rng.integers(0, len(_WILD_TOML)))]}"
    return "\n".join(lines).encode()


def _column(column: pa.ChunkedArray, rng: Rng) -> pa.Array:
    """Return a column that says something else: another type, nulls, values no sensor gives."""
    n, how = len(column), int(rng.integers(0, 8))
    if how == 0 or pa.types.is_nested(column.type) or pa.types.is_dictionary(column.type):
        return pa.nulls(n, column.type)
    if how == 1:
        return pa.array([str(v) for v in column.to_pylist()])
    if how == 2:
        return pa.array([[v] for v in column.to_pylist()])
    if how == 3:
        return pa.array([_spot(v, rng) for v in column.to_pylist()], pa.float64())
    if how == 4:
        return column.combine_chunks().take(pa.array(rng.integers(0, max(n, 1), n)))
    if how == 5:
        return column.combine_chunks().dictionary_encode()
    if how == 6:
        return pa.array(np.full(n, rng.choice([0.0, 1e308, -1e308, 1e-320, np.nan, np.inf])))
    return pa.array([None if rng.random() < 0.3 else v for v in column.to_pylist()], column.type)


def _spot(value: Any, rng: Rng) -> float | None:
    if rng.random() < 0.02:
        return float(rng.choice([np.nan, np.inf, -np.inf, 1e308, -1e308]))
    return value if isinstance(value, float) else None


def _table(table: pa.Table, rng: Rng) -> bytes:
    for _ in range(int(rng.integers(1, 4))):
        if not table.num_columns:
            break
        i, how = int(rng.integers(0, table.num_columns)), int(rng.integers(0, 8))
        name = table.column_names[i]
        if how == 0:
            table = table.remove_column(i)
        elif how == 1:
            table = table.rename_columns([c + "x" if c == name else c for c in table.column_names])
        elif how == 2:
            table = table.slice(0, int(rng.integers(0, 20)))
        elif how == 3:
            table = table.append_column(name, table.column(i))
        elif how == 4:
            metadata = dict(table.schema.metadata or {})
            metadata[b"sstl"] = json.dumps(_WILD[int(rng.integers(0, len(_WILD)))]).encode()
            table = table.replace_schema_metadata(metadata)
        elif table.num_rows:
            table = table.set_column(i, name, _column(table.column(i), rng))
    buffer = io.BytesIO()
    pq.write_table(table, buffer)
    return buffer.getvalue()

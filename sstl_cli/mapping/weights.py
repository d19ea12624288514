"""Model files: safetensors with the header in their metadata; nothing in them is ever executed."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from sstl_cli.core.config import parse
from sstl_cli.core.errors import SstlError
from sstl_cli.core.files import atomic
from sstl_cli.mapping.header import Header, weight_shapes
from sstl_cli.mapping.inference import SCALING, Group, MappingModel, Weights

MAX_BYTES = 1 << 30
MAX_HEADER_BYTES = 16 << 20
FIX = "train it again with this version of sstl"


def save_model(path: Path, model: MappingModel, force: bool = False) -> None:
    """Write a model atomically; the same model gives the same bytes.

    Raises
    ------
    SstlError
        If the output exists without ``force``, or cannot be written.
    """
    with atomic(Path(path), force) as temporary:
        temporary.write_bytes(to_bytes(model))


def to_bytes(model: MappingModel) -> bytes:
    """Return a model as the bytes of a safetensors file."""
    tensors: Weights = {}
    for g, group in enumerate(model.groups):
        tensors.update({f"{g}/{k}": v for k, v in group.scaling.items()})
        tensors.update({f"{g}/{n}/{k}": v for n, w in group.variants.items() for k, v in w.items()})
    raw = save({k: np.ascontiguousarray(v) for k, v in sorted(tensors.items())})
    length = struct.unpack("<Q", raw[:8])[0]
    # the library keeps metadata in a hash map whose order changes from run to run, so the header is laid here
    header = json.loads(raw[8 : 8 + length])
    fields = model.header.model_dump(mode="json")
    notes = {k: v if isinstance(v, str) else json.dumps(v, ensure_ascii=False) for k, v in fields.items()}
    text = json.dumps({"__metadata__": notes, **header}, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + raw[8 + length :]


def load_model(path: Path | str) -> MappingModel:
    """Read a model and check all of it before use.

    Raises
    ------
    SstlError
        E130 if there is no such file, E510 if it is not a safetensors file, E511 if it is not a mapping model or says
        something impossible about itself, E512 if weights are missing, of wrong shape or type, or not finite.
    """
    path = Path(path)
    where = str(path)
    if not path.is_file():
        raise SstlError("file not found" if not path.exists() else "is not a file", where=where, fix="correct the path", code="E130")
    if path.stat().st_size > MAX_BYTES:
        raise SstlError("is larger than 1 GiB: not a mapping model", where=where, fix=FIX, code="E510")
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise SstlError(f"cannot be read: {error.strerror}", where=where, code="E510") from None
    header = _header(raw, where)
    try:
        tensors = load(raw)
    except (SafetensorError, ValueError, KeyError, TypeError) as error:
        raise SstlError(f"is damaged ({str(error)[:100]})", where=where, fix=FIX, code="E510") from None
    return MappingModel(header, _groups(header, tensors, where))


def _header(raw: bytes, where: str) -> Header:
    length = struct.unpack("<Q", raw[:8])[0] if len(raw) >= 8 else 0
    if not 0 < length <= min(MAX_HEADER_BYTES, len(raw) - 8):
        raise SstlError("is not a safetensors file", where=where, fix=FIX, code="E510")
    try:
        notes = json.loads(raw[8 : 8 + length]).get("__metadata__")
    except (ValueError, AttributeError, RecursionError):
        raise SstlError("is not a safetensors file", where=where, fix=FIX, code="E510") from None
    if not isinstance(notes, dict) or notes.get("schema_id") != "sstl.mapping":
        raise SstlError("is not a mapping model of sstl", where=where, fix=FIX, code="E511")
    document = {}
    for key, text in notes.items():
        kind = Header.model_fields[key].annotation if key in Header.model_fields else str
        try:
            plain = key in ("schema_id", "default", "strategy") or kind is str
            document[key] = text if plain else json.loads(text)
        except (ValueError, TypeError, RecursionError):
            raise SstlError(f"metadata '{key}' is damaged", where=where, fix=FIX, code="E511") from None
    try:
        return parse(Header, document, where)
    except SstlError as error:
        raise SstlError(f"metadata: {error.what}", where=where, fix=FIX, code="E511") from None


def _groups(header: Header, tensors: Weights, where: str) -> tuple[Group, ...]:
    seeds = len(header.seeds)
    known: set[str] = set()

    def take(key: str, shape: tuple[int, ...]) -> np.ndarray:
        known.add(key)
        found = tensors.get(key)
        if found is None:
            raise SstlError(f"weights '{key}' are missing", where=where, fix=FIX, code="E512")
        if found.shape != shape or found.dtype not in (np.float32, np.float64):
            raise SstlError(f"weights '{key}' are {found.dtype} {found.shape}, not floats {shape}", where=where, fix=FIX, code="E512")
        if not np.isfinite(found).all():
            raise SstlError(f"weights '{key}' are not all finite", where=where, fix=FIX, code="E512")
        return found

    groups = []
    for g in range(header.group_count):
        scaling = {k: take(f"{g}/{k}", (seeds, 2)) for k in SCALING}
        if not (scaling["x_scale"] > 0).all():
            raise SstlError("input scaling is not positive", where=where, fix=FIX, code="E512")
        variants: dict[str, Weights] = {
            v.name: {k: take(f"{g}/{v.name}/{k}", s) for k, s in weight_shapes(v.alpha, seeds, header.inputs).items()}
            for v in header.variants
        }
        groups.append(Group(scaling, variants))
    spare = sorted(set(tensors) - known)
    if spare:
        raise SstlError(f"holds unknown weights '{spare[0]}'", where=where, fix=FIX, code="E512")
    return tuple(groups)

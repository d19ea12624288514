"""HDF5: every numeric or text dataset is a channel by its path; external files are never followed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.core.units import is_unit
from sstl_cli.importers.base import Block, Channel, Layout, Notes, check_declared, guarded, require_few, same_length, slices, text_array
from sstl_cli.importers.isolate import isolated, isolated_blocks

ID = "hdf5"
TITLE = "an HDF5 file"
EXTENSIONS = (".h5", ".hdf5", ".hdf", ".he5")
RANK = 25
MAX_DEPTH = 16
MAX_COLUMNS = 512
# a chunk is unpacked whole for each of its rows that is read, unless the library can keep it
MAX_CHUNK_BYTES = 64 << 20
SIGNATURE = b"\x89HDF\r\n\x1a\n"


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the signature stands at byte 0, 512, 1024, ... and no MATLAB text before it."""
    return has_signature(head) and not head.startswith(b"MATLAB")


# of attributes that may tell labels
MAX_GROUPS, MAX_REMARK, MAX_ATTRIBUTE_DEPTH = 64, 200, 3
# of a dataset's own attributes, those that its readings may still need
_CORRECTS = re.compile("offset|scale|gain|factor", re.IGNORECASE)
# in front of an attribute's name, behind its group's
ATTRIBUTE = "@"


def has_signature(head: bytes) -> bool:
    """Return whether an HDF5 signature stands where the format allows it."""
    return any(head[at : at + 8] == SIGNATURE for at in (0, 512, 1024, 2048, 4096))


def channels(path: Path, layout: Layout) -> list[Channel]:
    """Return datasets by path (``group/name``), matrix columns as ``name[2]``, compound fields as ``name.field``."""
    with guarded(path, TITLE):
        return isolated(lambda: list_channels(path, matlab=False), path)


def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
    """Yield blocks of the named datasets."""
    with guarded(path, TITLE):
        yield from isolated_blocks(lambda: read_blocks(path, numbers, labels, matlab=False), path)


def remarks(path: Path) -> list[str]:
    """Return the attributes of the file and its groups, and those of datasets that correct their readings, as ``name: value``."""
    with guarded(path, TITLE):
        return [c.name for c in isolated(lambda: _attributes(path), path)]


def _attributes(path: Path) -> list[Channel]:
    import h5py

    with h5py.File(path, "r") as file:
        groups = [
            file,
            *(file[k] for k in file if isinstance(file.get(k, getlink=True), h5py.HardLink) and isinstance(file[k], h5py.Group)),
        ]
        # as channels they go through the pipe of the child process
        held = [
            (k, v) for group in groups[:MAX_GROUPS] for k, v in group.attrs.items() if isinstance(v, (str, bytes, int, float, np.number))
        ]
        # scale_factor and add_offset stand at the readings themselves
        held += [
            (f"{name} {k}", v)
            for name, dataset in islice(walk(file, path), MAX_GROUPS)
            for k, v in dataset.attrs.items()
            if isinstance(v, (int, float, np.number)) and _CORRECTS.search(k)
        ]
        return [Channel(f"{k}: {v.decode('utf-8', 'replace') if isinstance(v, bytes) else v}"[:MAX_REMARK]) for k, v in held]


def list_channels(path: Path, matlab: bool) -> list[Channel]:
    """Return the channels of an HDF5 file, with MATLAB's conventions where asked."""
    import h5py

    out: list[Channel] = []
    with h5py.File(path, "r") as file:
        if not matlab:
            out += [Channel(name, 1, text=isinstance(value, str)) for name, value in _of_groups(file)]
        for name, dataset in walk(file, path):
            if matlab and is_char(dataset):
                out.append(Channel(name.replace("/", "."), 1, text=True))
                continue
            unit = dataset.attrs.get("unit", dataset.attrs.get("units", ""))
            unit = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else unit
            unit = unit if isinstance(unit, str) and is_unit(unit) else ""
            shown = name.replace("/", ".") if matlab else name
            text = dataset.dtype.kind in "SO"
            if dataset.dtype.names:
                out += [Channel(f"{shown}.{f}", rows_of(dataset, matlab), text=dataset.dtype[f].kind in "SO") for f in dataset.dtype.names]
            elif width(dataset, matlab) > 1:
                out += [Channel(f"{shown}[{i + 1}]", rows_of(dataset, matlab), unit) for i in range(width(dataset, matlab))]
            else:
                out.append(Channel(shown, rows_of(dataset, matlab), unit, text=text))
            require_few(path, len(out))
    return out


def read_blocks(path: Path, numbers: list[str], labels: list[str], matlab: bool) -> Iterator[Block]:
    """Yield blocks of the named channels, sliced from the file."""
    import h5py

    wanted = list(dict.fromkeys([*numbers, *labels]))
    with h5py.File(path, "r", rdcc_nbytes=MAX_CHUNK_BYTES) as file:
        columns: dict[str, Callable[[int, int], Any]] = {}
        lengths: dict[str, int] = {}
        for name, dataset in walk(file, path):
            shown = name.replace("/", ".") if matlab else name
            for full in wanted:
                if full == shown or full.startswith((shown + "[", shown + ".")):
                    rest = full[len(shown) :]
                    if rest.startswith(".") and not dataset.dtype.names:
                        continue
                    columns[full] = _cutter(dataset, rest, full in numbers, matlab, path, full)
                    lengths[full] = 1 if matlab and is_char(dataset) else rows_of(dataset, matlab)
        for full, value in _of_groups(file) if any(ATTRIBUTE in n for n in wanted) else ():
            if full in wanted:
                columns[full], lengths[full] = _constant(value, full in numbers, path, full), 1
        rows = same_length(path, lengths)
        columns = {n: (c if lengths[n] > 1 or rows == 1 else _single(c)) for n, c in columns.items()}
        yield from slices(rows, columns, path.stat().st_size)


def _of_groups(file: Any) -> Iterator[tuple[str, str | float]]:
    """Yield the attributes of groups that hold one value, as channels of one (``run01/@bend_deg``)."""
    import h5py

    stack = [("", file, 0)]
    count = 0
    while stack and count < MAX_GROUPS:
        prefix, group, depth = stack.pop()
        count += 1
        for key, value in group.attrs.items() if prefix else ():
            if isinstance(value, (str, bytes, int, float, np.number)) and len(str(value)) <= MAX_REMARK:
                plain = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
                yield f"{prefix}{ATTRIBUTE}{key}", plain if isinstance(plain, str) else float(plain)
        for key in sorted(group.keys(), reverse=True) if depth < MAX_ATTRIBUTE_DEPTH else ():
            if isinstance(group.get(key, getlink=True), h5py.HardLink) and isinstance(item := group[key], h5py.Group):
                stack.append((f"{prefix}{key}/", item, depth + 1))


def _constant(value: str | float, number: bool, path: Path, name: str) -> Callable[[int, int], Any]:
    """Return a cutter for an attribute."""
    if number and isinstance(value, str):
        raise SstlError(f"'{name}' holds text, not numbers", where=str(path), fix="map another dataset", code="E328")
    return lambda a, b: np.array([value], np.float64) if number else text_array(np.array([value]))


def _single(cut: Callable[[int, int], Any]) -> Callable[[int, int], Any]:
    """Return a cutter that repeats a single value."""
    return lambda a, b: cut(0, 1)


def walk(file: Any, path: Path) -> Iterator[tuple[str, Any]]:
    """Yield the usable datasets of a file by path; links to other files are refused, declared sizes checked."""
    import h5py

    size = path.stat().st_size
    # with each group those that it stands in, by their places in the file: one that holds itself is read once
    stack: list[tuple[str, Any, tuple[int, ...]]] = [("", file, ())]
    count = 0
    while stack:
        prefix, group, above = stack.pop()
        place = h5py.h5o.get_info(group.id).addr
        if place in above or len(above) > MAX_DEPTH:
            continue
        below: list[tuple[str, Any, tuple[int, ...]]] = []
        for key in sorted(group.keys()):
            count += 1
            require_few(path, count, "groups and datasets")
            if key.startswith("#"):
                continue
            link = group.get(key, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise SstlError(
                    f"'{prefix}{key}' is a link to another file", where=str(path), fix="copy the data into one file", code="E315"
                )
            if isinstance(link, h5py.SoftLink):
                continue
            item = group[key]
            if isinstance(item, h5py.Group):
                below.append((f"{prefix}{key}/", item, (*above, place)))
            elif isinstance(item, h5py.Dataset) and _usable(item):
                if item.external or item.is_virtual:
                    raise SstlError(
                        f"'{prefix}{key}' keeps its values in another file", where=str(path), fix="copy the data into one file", code="E315"
                    )
                _check(path, prefix + key, item, size)
                yield prefix + key, item
        # the last is taken first
        stack += reversed(below)


def is_char(dataset: Any) -> bool:
    """Return whether a MATLAB dataset holds text as character codes."""
    kind = dataset.attrs.get("MATLAB_class", b"")
    return (kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)) == "char"


def width(dataset: Any, matlab: bool) -> int:
    """Return the number of columns of a matrix dataset (1 for a vector)."""
    if dataset.ndim != 2 or 1 in dataset.shape:
        return 1
    return int(min(dataset.shape[0 if matlab else 1], MAX_COLUMNS))


def rows_of(dataset: Any, matlab: bool) -> int:
    """Return the number of samples in a dataset."""
    if dataset.ndim == 2 and 1 not in dataset.shape:
        return int(dataset.shape[1 if matlab else 0])
    return int(dataset.size) if dataset.ndim else 1


def _usable(dataset: Any) -> bool:
    if dataset.dtype.kind == "O":
        import h5py

        return h5py.check_string_dtype(dataset.dtype) is not None and dataset.ndim <= 1
    return dataset.shape is not None and dataset.ndim <= 2 and dataset.dtype.kind in "biufSV" and dataset.size > 0


def _check(path: Path, name: str, dataset: Any, size: int) -> None:
    declared = int(np.prod(dataset.shape, dtype=object)) * max(dataset.dtype.itemsize, 1) if dataset.ndim else 1
    check_declared(path, declared, f"dataset '{name}'", size)
    chunk = int(np.prod(dataset.chunks, dtype=object)) * max(dataset.dtype.itemsize, 1) if dataset.chunks else 0
    if chunk > MAX_CHUNK_BYTES:
        raise SstlError(
            f"dataset '{name}' has chunks of {chunk:.3g} bytes", where=str(path), fix=f"at most {MAX_CHUNK_BYTES >> 20} MiB", code="E312"
        )
    if declared > 1 << 20 and dataset.id.get_storage_size() == 0:
        raise SstlError(f"dataset '{name}' declares {declared:.3g} bytes and stores none", where=str(path), code="E312")


def _cutter(dataset: Any, rest: str, number: bool, matlab: bool, path: Path, name: str) -> Callable[[int, int], Any]:
    def piece(a: int, b: int) -> Any:
        if matlab and is_char(dataset):
            return text_array(["".join(map(chr, np.asarray(dataset[()]).ravel().tolist()[:4096]))])
        if dataset.ndim == 0:
            values = np.asarray(dataset[()]).reshape(1)
        elif dataset.ndim == 1:
            values = dataset[a:b]
        elif rest.startswith("["):
            at = int(rest[1:-1]) - 1
            values = dataset[at, a:b] if matlab else dataset[a:b, at]
        else:
            values = dataset[0, a:b] if dataset.shape[0] == 1 else dataset[a:b, 0]
        if rest.startswith(".") and dataset.dtype.names:
            values = values[rest[1:]]
        if number:
            if values.dtype.kind not in "biuf":
                raise SstlError(f"'{name}' holds text, not numbers", where=str(path), fix="map another dataset", code="E328")
            return values.astype(np.float64)
        return text_array(values)

    return piece

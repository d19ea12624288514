"""Reading with a C library in a child process: damaged bytes may end the child, never the program."""

from __future__ import annotations

import json
import os
import select
import signal
import struct
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any, TypeAlias

import numpy as np
import pyarrow as pa

from sstl_cli.core.errors import SstlError
from sstl_cli.core.workers import end_with_thread
from sstl_cli.importers.base import Block, Channel, Values

# a head that goes through the pipe as JSON, and the bytes of the columns that it names
Message: TypeAlias = tuple[dict[str, Any], list[bytes]]
TIMEOUT_S = 60.0
CHILD_BYTES = 4 << 30
MAX_MESSAGE = 1 << 30


def isolated(list_them: Callable[[], list[Channel]], path: Path) -> list[Channel]:
    """Return the channels that ``list_them`` finds, computed in a child process."""
    if not hasattr(os, "fork"):
        return list_them()

    def messages() -> Iterator[Message]:
        rows = [[c.name, c.rows, c.unit, c.time, c.text] for c in list_them()]
        yield {"channels": rows}, []

    for head, _ in _from_child(messages, path):
        return [Channel(*row) for row in head["channels"]]
    return []


def isolated_blocks(read_them: Callable[[], Iterator[Block]], path: Path) -> Iterator[Block]:
    """Yield the blocks that ``read_them`` yields, read in a child process."""
    if not hasattr(os, "fork"):
        yield from read_them()
        return

    def messages() -> Iterator[Message]:
        for block in read_them():
            columns, bodies = [], []
            for name, values in block.columns.items():
                if isinstance(values, np.ndarray):
                    body = np.ascontiguousarray(values, np.float64).tobytes()
                else:
                    body = json.dumps(values.to_pylist()).encode()
                number = isinstance(values, np.ndarray)
                columns.append([name, number, len(body)])
                bodies.append(body)
            yield {"columns": columns, "position": block.position}, bodies

    for head, bodies in _from_child(messages, path):
        out: dict[str, Values] = {}
        for (name, number, _), body in zip(head["columns"], bodies, strict=True):
            out[name] = np.frombuffer(body, np.float64) if number else pa.array(json.loads(body), pa.string())
        yield Block(out, int(head["position"]))


def _from_child(messages: Callable[[], Iterator[Message]], path: Path) -> Iterator[Message]:
    incoming, outgoing = os.pipe()
    parent = os.getpid()
    child = os.fork()
    if child == 0:
        end_with_thread(parent)
        os.close(incoming)
        _be_child(messages, outgoing, path)
    os.close(outgoing)
    try:
        with os.fdopen(incoming, "rb", buffering=0) as pipe:
            while True:
                head = json.loads(_message(pipe, path))
                if "error" in head:
                    raise SstlError(head["error"], where=head["where"], fix=head["fix"], code=head["code"])
                if "done" in head:
                    return
                bodies = [_exactly(pipe, n, path) for _, _, n in head.get("columns", [])]
                yield head, bodies
    finally:
        # whatever state the child is in, nobody listens any more
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


def _be_child(messages: Callable[[], Iterator[Message]], outgoing: int, path: Path) -> None:
    """Write all messages, then end without running the parent's clean-up."""
    code = 1
    try:
        _limit()
        with os.fdopen(outgoing, "wb") as pipe:
            try:
                for head, bodies in messages():
                    _send(pipe, head, bodies)
                _send(pipe, {"done": True}, [])
            except SstlError as error:
                _send(pipe, {"error": error.what, "where": error.where, "fix": error.fix, "code": error.code}, [])
            except BaseException as error:
                detail = " ".join(f"{type(error).__name__}: {error}".split())[:110]
                _send(
                    pipe,
                    {"error": f"is truncated or damaged ({detail})", "where": str(path), "fix": "record or copy it again", "code": "E310"},
                    [],
                )
        code = 0
    finally:
        os._exit(code)


def _limit() -> None:
    import resource

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with open("/proc/self/statm", encoding="ascii") if os.path.exists("/proc/self/statm") else open(os.devnull) as file:
        used = int((file.read().split() or ["0"])[0]) * resource.getpagesize()
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = used + CHILD_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (wanted if hard == resource.RLIM_INFINITY else min(wanted, hard), hard))


def _send(pipe: IO[bytes], head: Mapping[str, object], bodies: list[bytes]) -> None:
    raw = json.dumps(head).encode()
    pipe.write(struct.pack("<Q", len(raw)) + raw)
    for body in bodies:
        pipe.write(body)
    pipe.flush()


def _message(pipe: Any, path: Path) -> bytes:
    (length,) = struct.unpack("<Q", _exactly(pipe, 8, path))
    return _exactly(pipe, length, path)


def _exactly(pipe: Any, n: int, path: Path) -> bytes:
    if n > MAX_MESSAGE:
        raise SstlError("sends too much at once", where=str(path), fix="export it as CSV or Parquet", code="E317")
    pieces, left = [], n
    while left:
        ready, _, _ = select.select([pipe], [], [], TIMEOUT_S)
        if not ready:
            raise SstlError(f"gives no value within {TIMEOUT_S:.0f} s", where=str(path), fix="the file is damaged or hostile", code="E317")
        piece = pipe.read(min(left, 1 << 20))
        if not piece:
            raise SstlError("is damaged so badly that its reader stopped", where=str(path), fix="record or copy it again", code="E317")
        pieces.append(piece)
        left -= len(piece)
    return b"".join(pieces)

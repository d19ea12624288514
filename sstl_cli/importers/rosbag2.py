"""ROS 2 bags in SQLite storage (``.db3``, or the bag's folder); MCAP storage is read by the MCAP importer."""

from __future__ import annotations

import re
import sqlite3
from pathlib import Path
from typing import Any

from sstl_cli.core.errors import SstlError
from sstl_cli.importers import bags
from sstl_cli.importers.bags import Messages, Topic
from sstl_cli.importers.base import members, need
from sstl_cli.importers.ros_messages import Definitions, Field, decoder, definitions, short

ID = "rosbag2"
TITLE = "a ROS 2 bag"
EXTENSIONS = (".db3",)
RANK = 42
MAX_MESSAGE_BYTES = 64 << 20


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the file is an SQLite database, or the folder holds one."""
    return head.startswith(b"SQLite format 3\0") or (path.is_dir() and any(m.suffix == ".db3" for m in members(path)))


def messages(path: Path) -> Messages:
    """Yield topic, receive time (ns), bytes and position of every message in file order."""
    done = 0
    for member in members(path):
        if path.is_dir() and member.suffix != ".db3":
            continue
        size = member.stat().st_size
        # immutable: no lock, no journal of a stranger's file is played back
        base = sqlite3.connect(f"{member.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
        try:
            base.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_MESSAGE_BYTES)
            base.execute("PRAGMA trusted_schema = OFF")
            base.execute("PRAGMA cell_size_check = ON")
            # work is counted, so that a view that loops forever ends
            budget = _Budget(size)
            base.set_progress_handler(budget.spend, 10_000)
            kinds = dict(base.execute("SELECT name, type FROM sqlite_master").fetchmany(200))
            if kinds.get("messages") != "table" or kinds.get("topics") != "table":
                raise SstlError("is an SQLite file without topics and messages", where=str(path), fix="give a ROS 2 bag", code="E347")
            topics = _topics(base, kinds, path)
            total = base.execute("SELECT max(rowid) FROM messages").fetchone()[0] or 1
            rows = base.execute("SELECT rowid, topic_id, timestamp, data FROM messages ORDER BY timestamp, rowid")
            for row, topic, time, data in rows:
                if topic not in topics or not isinstance(time, int) or not isinstance(data, bytes):
                    raise SstlError(
                        "has a message without topic, time or data", where=str(path), fix="record or convert it again", code="E310"
                    )
                yield topics[topic], time, data, done + int(size * min(row / total, 1.0))
        finally:
            base.close()
        done += size


class _Budget:
    """Ends a query that works far longer than the file's size explains."""

    def __init__(self, size: int) -> None:
        self.left = 200 + size // 512

    def spend(self) -> int:
        self.left -= 1
        return int(self.left < 0)


def _topics(base: sqlite3.Connection, kinds: dict[str, str], path: Path) -> dict[int, Topic]:
    texts: dict[str, str] = {}
    if kinds.get("message_definitions") == "table":
        rows = base.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions").fetchmany(10_000)
        texts = {str(k): str(t) for k, e, t in rows if e == "ros2msg"}
    out: dict[int, Topic] = {}
    for number, name, kind, how in base.execute("SELECT id, name, type, serialization_format FROM topics").fetchmany(10_000):
        name, kind = str(name), str(kind)
        try:
            known = definitions(kind, texts[kind]) if texts.get(kind) else _standard(kind, path)
            out[number] = Topic(name, decoder(str(how), kind, known))
        except ValueError as error:
            out[number] = Topic(name, None, str(error))
    return out


def _standard(kind: str, path: Path) -> Definitions:
    """Return the fields of a standard message type, for bags that were recorded without definitions."""
    typesys: Any = need(path, "rosbags.typesys", "robot")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE).fielddefs
    out: Definitions = {}
    todo = [kind if "/msg/" in kind else re.sub("/", "/msg/", kind, count=1)]
    while todo:
        name = todo.pop()
        if name not in store:
            raise ValueError(f"message type '{name}' is not standard and the bag holds no definition")
        fields = []
        for field, (node, detail) in store[name][1]:
            length = None
            # 1 single base type, 2 named type, 3 array of fixed length, 4 sequence
            if int(node) in (3, 4):
                inner, bound = detail
                length = int(bound) if int(node) == 3 else 0
                node, detail = inner
            base = detail[0] if isinstance(detail, tuple) else detail
            if int(node) == 2 and short(base) not in out and base not in todo:
                todo.append(base)
            fields.append(Field(field, short(base), length))
        out[short(name)] = fields
    return out


channels, read = bags.functions(TITLE, messages)

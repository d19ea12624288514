"""MCAP logs (Foxglove, ROS 2): messages as JSON, CDR or ROS 1."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from sstl_cli.core.errors import SstlError
from sstl_cli.importers import bags
from sstl_cli.importers.bags import Messages, Topic
from sstl_cli.importers.base import members, need
from sstl_cli.importers.ros_messages import decoder, definitions
from sstl_cli.importers.unpack import unpacked

ID = "mcap"
TITLE = "an MCAP log"
EXTENSIONS = (".mcap",)
RANK = 40
MAX_RECORD_BYTES = 256 << 20
_MAGIC = b"\x89MCAP0\r\n"


def sniff(head: bytes, path: Path) -> bool:
    """Return whether the file (or the first file of a bag folder) begins with the MCAP magic."""
    return head.startswith(_MAGIC) or (path.is_dir() and any(m.suffix == ".mcap" for m in members(path)))


def messages(path: Path) -> Messages:
    """Yield topic, log time (ns), bytes and position of every message in file order."""
    reader = need(path, "mcap.stream_reader", "robot")
    records = need(path, "mcap.records", "robot")
    done = 0
    for member in members(path):
        if member.suffix != ".mcap" and path.is_dir():
            continue
        size = member.stat().st_size
        schemas: dict[int, Any] = {}
        topics: dict[int, Topic] = {}
        with open(member, "rb") as file:
            stream = reader.StreamReader(file, emit_chunks=True, record_size_limit=min(MAX_RECORD_BYTES, size))
            for record in stream.records:
                if isinstance(record, records.Chunk):
                    data = unpacked(record.data, record.compression, record.uncompressed_size, path)
                    plain = records.Chunk(
                        compression="", data=data, message_end_time=0, message_start_time=0, uncompressed_crc=0, uncompressed_size=len(data)
                    )
                    inner = reader.breakup_chunk(plain)
                else:
                    inner = [record]
                for item in inner:
                    if isinstance(item, records.Schema):
                        schemas[item.id] = item
                    elif isinstance(item, records.Channel):
                        topics[item.id] = _topic(item, schemas)
                    elif isinstance(item, records.Message):
                        if item.channel_id not in topics:
                            raise SstlError(
                                "has a message of an undeclared channel", where=str(path), fix="record or convert it again", code="E310"
                            )
                        yield topics[item.channel_id], item.log_time, item.data, done + file.tell()
        done += size


def _topic(channel: Any, schemas: dict[int, Any]) -> Topic:
    schema = schemas.get(channel.schema_id)
    encoding = channel.message_encoding
    try:
        if encoding == "json":
            return Topic(channel.topic, decoder(encoding, "", {}), units=_units(schema))
        if schema is None or schema.encoding not in ("ros1msg", "ros2msg"):
            found = schema.encoding if schema is not None else "no schema"
            raise ValueError(f"message encoding '{encoding}' ({found}) is not supported; json, CDR and ROS 1 are")
        known = definitions(schema.name, schema.data.decode("utf-8", "replace"))
        return Topic(channel.topic, decoder(encoding, schema.name, known))
    except ValueError as error:
        return Topic(channel.topic, None, str(error))


def _units(schema: Any) -> dict[str, str]:
    """Return the units that the schema of an exported log states; other schemas describe in words."""
    if schema is None or schema.name != "sstl.log":
        return {}
    try:
        fields = json.loads(schema.data)["properties"].items()
        return {str(name): str(field.get("description", "")) for name, field in fields}
    except (ValueError, KeyError, TypeError, AttributeError):
        return {}


channels, read = bags.functions(TITLE, messages)

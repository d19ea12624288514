"""What the robot log formats share: topics become channels ``/topic.field`` with the clock ``/topic@time``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import Block, Channel, Layout, Notes, Values, guarded, text_array
from sstl_cli.importers.ros_messages import Flat

TIME = "@time"
MESSAGES_PER_BLOCK = 65_536
# topics that begin later than this are not offered
LISTED_MESSAGES = 1_000_000


@dataclass(frozen=True)
class Topic:
    """A topic: its name, its decoder or why there is none, and the units its schema states by field."""

    name: str
    decode: Callable[[bytes], Flat] | None
    why: str = ""
    units: dict[str, str] = field(default_factory=dict)


# topic, log time in ns, message bytes, bytes of the file read so far
Messages = Iterator[tuple[Topic, int, bytes, int]]


def functions(
    title: str, messages: Callable[[Path], Messages]
) -> tuple[Callable[[Path, Layout], list[Channel]], Callable[[Path, list[str], list[str], Layout, Notes], Iterator[Block]]]:
    """Return the functions ``channels`` and ``read`` of a format, by the function that yields the messages of its files."""

    def channels(path: Path, layout: Layout) -> list[Channel]:
        """Return ``/topic.field`` for every number and text in the first messages of each topic."""
        with guarded(path, title):
            return _list_channels(messages(path), path)

    def read(path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
        """Yield blocks of channels of one topic."""
        with guarded(path, title):
            yield from _read_blocks(messages(path), numbers, labels, path)

    return channels, read


def _list_channels(messages: Messages, path: Path) -> list[Channel]:
    """Return the channels seen in the first messages of each topic.

    Every field is one channel; ``/topic@time`` is the log time, ``/topic.header.stamp`` the sender's own.
    """
    found: dict[str, Channel] = {}
    refused: dict[str, str] = {}
    seen: dict[str, int] = {}
    for n, (topic, _, data, _) in enumerate(messages):
        if n > LISTED_MESSAGES and seen:
            break
        if topic.decode is None:
            refused[topic.name] = topic.why
            continue
        if seen.setdefault(topic.name, 0) >= 3:
            continue
        seen[topic.name] += 1
        clock = topic.name + TIME
        found.setdefault(clock, Channel(clock, None, "s"))
        for key, value in topic.decode(data).items():
            name = f"{topic.name}.{key.removesuffix('@ns')}"
            unit = "s" if key.endswith("@ns") else topic.units.get(key, "")
            found.setdefault(name, Channel(name, None, unit, clock, text=isinstance(value, str)))
    if not found:
        why = "; ".join(f"{t}: {w}" for t, w in list(refused.items())[:4]) or "it holds no message"
        raise SstlError(f"holds no readable message ({why})", where=str(path), fix="record json, ROS 1 or CDR messages", code="E347")
    return list(found.values())


def _read_blocks(messages: Messages, numbers: list[str], labels: list[str], path: Path) -> Iterator[Block]:
    """Yield blocks of channels that stand in one topic; times are seconds since the first message of the file."""
    wanted = list(dict.fromkeys([*numbers, *labels]))
    rows: dict[str, list[Any]] = {w: [] for w in wanted}
    origin: int | None = None
    topic_name: str | None = None
    position = 0
    for topic, time, data, position in messages:
        origin = time if origin is None else origin
        if topic_name is None:
            topic_name = _topic_of(topic.name, wanted, path)
        if topic.name != topic_name:
            continue
        if topic.decode is None:
            raise SstlError(f"topic '{topic.name}': {topic.why}", where=str(path), code="E347")
        flat = topic.decode(data)
        for name in wanted:
            rest = name[len(topic.name) :]
            if rest == TIME:
                value: Any = (time - origin) * 1e-9
            else:
                key = rest[1:]
                stamp = flat.get(key + "@ns")
                value = (stamp - origin) * 1e-9 if stamp is not None else flat.get(key)
            rows[name].append(value)
        if len(rows[wanted[0]]) >= MESSAGES_PER_BLOCK:
            yield _block(rows, numbers, position, path)
            rows = {w: [] for w in wanted}
    if topic_name is not None and rows[wanted[0]]:
        yield _block(rows, numbers, position, path)


def _topic_of(seen: str, wanted: list[str], path: Path) -> str | None:
    """Return the seen topic if all wanted channels are its own."""
    mine = [w for w in wanted if w.startswith((seen + ".", seen + "@"))]
    if mine and len(mine) != len(wanted):
        other = next(w for w in wanted if w not in mine)
        raise SstlError(
            f"'{mine[0]}' and '{other}' stand in different topics",
            where=str(path),
            fix='give each its own time = "/topic@time" in the mapping',
            code="E339",
        )
    return seen if mine else None


def _block(rows: dict[str, list[Any]], numbers: list[str], position: int, path: Path) -> Block:
    columns: dict[str, Values] = {}
    for name, values in rows.items():
        if name in numbers:
            if any(isinstance(v, str) for v in values):
                raise SstlError(f"'{name}' holds text, not numbers", where=str(path), fix="map another field", code="E328")
            columns[name] = np.array([np.nan if v is None else float(v) for v in values], np.float64)
        else:
            columns[name] = text_array(values)
    return Block(columns, position)

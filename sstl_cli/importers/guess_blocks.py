"""Tables of one header below each other in a text log: whether each is a run, and the labels that its own lines tell."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, takewhile
from pathlib import Path

from sstl_cli.core.sound import GAP_PERIODS
from sstl_cli.importers import text
from sstl_cli.importers.base import Block, Channel, Layout, Notes
from sstl_cli.importers.guess_angles import COUNTED
from sstl_cli.importers.guess_files import name_pattern
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.guess_parts import TRIAL
from sstl_cli.importers.guess_remarks import alike, bend_said, system_said
from sstl_cli.importers.guess_words import QUANTITY, words
from sstl_cli.importers.mapping import LABELS
from sstl_cli.importers.pattern import search
from sstl_cli.importers.rates_said import LONGEST, rate_said
from sstl_cli.importers.systems import known_system
from sstl_cli.importers.text_blocks import NAME, Part, head_of, parts_of
from sstl_cli.importers.text_cells import cut
from sstl_cli.importers.text_file import opened
from sstl_cli.importers.text_layout import TextLayout, as_text, layout_of
from sstl_cli.importers.text_stamps import StampReader

_SHAPES = (r"\d+", r"\d+(?:[.,]\d+)?", r"[A-Za-z]+", r"[\w.+-]+")
_SHOWN = 48
# what is to be written there
_OPEN = "..."
# the last two words in front of a place
_NEAR = re.compile(r"[\W_]*(?:[^\W\d_]+[\W_]*){0,2}$")
# a setting with its value, or a date
_NO_TITLE = re.compile(r"[:=;\t]|\d{4}")
# Delta_X, Y_Unit_Label, Units, Gain; ch. 2 range: not the rate of a motion
_SETTING = re.compile(
    r"[\W_]*([^:=;,\t]*(?:unit|einheit|scal|skal|gain|verst|range|bereich|sensitiv|empfind|calib|kalib|factor|faktor|delta|polarity"
    r"|offset|tare|tara|zero|nullpunkt)[^:=;,\t]*)[:=;,\t](.*)",
    re.IGNORECASE,
)
# Run 1, Latest; Specimen 2
_RUNS = COUNTED | TRIAL | words("latest data record specimen probe muestra eprouvette provino of")
_TIMES = words(f"{QUANTITY['time']} start started begin begun beginn")
REPEATED = 'the clock goes on where the header stands again: does a run begin there? Write "append" if the header is only repeated'


@dataclass(frozen=True)
class Told:
    """The lines above the header of a block, the line it begins at, and its first and last reading."""

    lines: tuple[str, ...]
    begins: int
    first: bytes
    last: bytes


@dataclass(frozen=True)
class Label:
    """A pattern for lines of blocks, and the question that it leaves."""

    pattern: str
    question: str = ""


@dataclass(eq=False)
class Stacked:
    """A text log of several blocks as a format: their rows one after the other, and the labels of each as channels."""

    layout: Layout
    rows_of_first: int
    labels: tuple[Label, ...]
    question: str
    reason: str
    ID: str = text.ID
    TITLE: str = text.TITLE
    EXTENSIONS: tuple[str, ...] = text.EXTENSIONS
    RANK: int = text.RANK

    def sniff(self, head: bytes, path: Path) -> bool:
        """Return False: a text log is told to hold blocks by what stands in it."""
        return False

    def channels(self, path: Path, layout: Layout) -> list[Channel]:
        """Return the columns, and a channel for each label that the blocks tell."""
        return [c for c in text.channels(path, self.layout) if c.name != NAME]

    def read(self, path: Path, numbers: list[str], labels: list[str], layout: Layout, notes: Notes) -> Iterator[Block]:
        """Yield the rows of all blocks."""
        return text.read(path, numbers, labels, self.layout, notes)

    def remarks(self, path: Path) -> list[str]:
        """Return the lines above the first block."""
        return text.remarks(path)

    def remarks_within(self, path: Path) -> list[str]:
        """Return the comments between the samples, and the lines of further blocks, where no label is taken from them."""
        return [] if self.labels else text.remarks_within(path)


def stacked(path: Path) -> Stacked | None:
    """Return what a text log of several blocks of one header is, None where it holds one.

    Raises
    ------
    SstlError
        E327 where the names of the columns stand there again above other units.
    """
    found = layout_of(path, Layout())
    blocks, rows = _blocks(path, found)
    if len(blocks) < 2:
        return None
    labels = _labels(blocks)
    layout = Layout(blocks="runs", block_lines=tuple(x.pattern for x in labels if _OPEN not in x.pattern))
    # runs that tell a label each are some, however their clocks go on
    told = any(not x.question for x in labels)
    asks = filter(None, ("" if told else _begins_anew(blocks, found), _otherwise(blocks)))
    lines = ", ".join(str(b.begins) for b in blocks[1:4])
    reason = f"its header stands there again in line {lines}{', ...' if blocks[4:] else ''}: {len(blocks)} blocks, each a run of its own"
    return Stacked(layout, rows, labels, "; ".join(asks), reason)


def of_all(held: Sequence[tuple[Path, Stacked | None]]) -> Stacked | None:
    """Return the blocks of several files, with a question where another file's lines tell labels otherwise; None where none holds several."""
    first = next((x for _, x in held if x is not None), None)
    if first is None:
        return None
    for path, other in held:
        if first.labels and (other is None or other.layout != first.layout):
            ask = f"lines of blocks in '{path.name}' tell labels otherwise: it needs a mapping of its own"
            return replace(first, question="; ".join(filter(None, (first.question, ask))))
    return first


def _blocks(path: Path, found: TextLayout) -> tuple[list[Told], int]:
    """Return all blocks of a file, and how many rows the first has."""
    head = head_of(path, found)
    if head is None:
        return [], 0
    blocks: list[Told] = []
    rows = 0
    with opened(path) as file:
        file.seek(found.first_byte)
        for part in parts_of(text.pieces(file, found, path, sys.maxsize), head, found, path, Notes()):
            first, last = _ends(part)
            if part.first or not blocks:
                blocks.append(Told(part.lines, part.begins, first, last))
            else:
                blocks[-1] = Told(blocks[-1].lines, blocks[-1].begins, blocks[-1].first, last)
            rows += part.body.count(b"\n") if part.number == 1 else 0
    return blocks, rows


def _ends(part: Part) -> tuple[bytes, bytes]:
    """Return the first and the last line of some rows."""
    # without a copy of what lies between
    body = part.body
    begin = next(i for i in range(len(body)) if not body[i : i + 1].isspace())
    end = next(i for i in range(len(body), 0, -1) if not body[i - 1 : i].isspace())
    first = body.find(b"\n", begin, end)
    return body[begin : first if first >= 0 else end], body[body.rfind(b"\n", 0, end) + 1 : end]


def _begins_anew(blocks: Sequence[Told], found: TextLayout) -> str:
    """Return a question where the clock of a block goes on by a step from that of the block before, as where a program only repeats its header."""
    at = next((i for i, n in enumerate(found.names) if said(n, found.units[i]).quantity == "time"), None)
    if at is None:
        return "no column is a clock: does a run begin with each header?"
    for one, other in pairwise(blocks):
        times = [_time(x, at, found) for x in (one.first, one.last, other.first)]
        if not all(map(math.isfinite, times)):
            return "does a run begin with each header?"
        usual = (times[1] - times[0]) / max(1, other.begins - one.begins)
        if times[1] < times[2] <= times[1] + GAP_PERIODS * usual:
            return REPEATED
    return ""


def _time(line: bytes, at: int, found: TextLayout) -> float:
    """Return what a line holds in a column of times, NaN where that cannot be read."""
    text_line = as_text(line)
    cells = cut(found.forms.line(text_line) if found.forms is not None else text_line, found.delimiter)
    try:
        if found.stamps[at]:
            return float(StampReader().seconds(cells[at : at + 1])[0])
        return float(cells[at].replace(found.decimal, "."))
    except (ValueError, IndexError):
        return math.nan


def _otherwise(blocks: Sequence[Told]) -> str:
    """Return a question where the lines of a block tell another rate, unit or scale than those of the first."""
    first = _settings(blocks[0])
    for block in blocks[1:]:
        for key, value in _settings(block).items():
            if first.get(key, value) != value:
                return f"'{key}' is {value[:_SHOWN]!r} in the block that begins at line {block.begins}, {first[key][:_SHOWN]!r} in the first: it needs a mapping of its own"
    return ""


def _settings(block: Told) -> dict[str, str]:
    """Return the lines of a block that tell how its readings are to be taken, by their first cells; of several the nearest."""
    found = [m for m in map(_SETTING.match, (x[:LONGEST] for x in block.lines)) if m]
    step = rate_said(block.lines)
    rate = {"sampling rate": f"{1.0 / step:g} Hz"} if math.isfinite(step) else {}
    return {m[1].strip(): m[2].strip(" \t,;") for m in found} | rate


def _labels(blocks: Sequence[Told]) -> tuple[Label, ...]:
    """Return patterns for the labels that lines of the blocks tell: of system and bend by their words, else by what titles have in common."""
    lines = [[x[:LONGEST] for x in b.lines] for b in blocks]
    most = max(map(len, lines[1:]))
    # what the first alone tells stands above the whole file
    systems = [_system_word(own) for own in lines]
    bends = [_bend(lines[0], most), *map(bend_said, lines[1:])]
    out = [_label(t, told, blocks) for t, told in (("system", systems), ("config_id", bends)) if any(v for v, _ in told[1:])]
    told = {k for k in LABELS for x in out if f"(?P<{k}>" in x.pattern}
    titled, found = _titled(blocks)
    if found > told and not titled.question:
        return (titled,)
    return tuple(out) if "config_id" in told or not titled.pattern else (*out, titled)


def _bend(lines: Sequence[str], most: int) -> tuple[str, str]:
    """Return the bend that lines above the first block tell, of several that of the last lines, as many as other blocks have: above them stands what is of the whole file."""
    told = bend_said(lines)
    return told if told[0] != "..." or not most else bend_said(lines[-most:])


def _system_word(lines: Sequence[str]) -> tuple[str, str]:
    """Return the word for the system that lines tell, and its line; a system without a word where a count of passes tells it."""
    told = system_said(lines, [])
    for line in reversed(lines) if told else ():
        for word in re.findall(r"[A-Za-z]+", line):
            if known_system(word) == told and system_said([line], []) == told:
                return word, line
    return ("...", lines[-1]) if told else ("", "")


def _label(target: str, told: Sequence[tuple[str, str]], blocks: Sequence[Told]) -> Label:
    """Return the pattern that takes a label from the line of each block, which is asked where one tells none or several, or it would take another."""
    for value, block in zip((v for v, _ in told), blocks, strict=True):
        if value in ("", "..."):
            what = "tells none" if not value else "tells it in other words, or several"
            return Label(f"(?P<{target}>{_OPEN})", f"the block that begins at line {block.begins} {what}: where does {target} stand?")
    places = [next(re.finditer(rf"(?<![\d.,]){re.escape(v)}(?!\d)", x), None) for v, x in told]
    fronts = [x[: m.start()] if m else "" for m, (_, x) in zip(places, told, strict=True)]
    backs = [x[m.end() :] if m else "" for m, (_, x) in zip(places, told, strict=True)]
    # two words tell the place, and what stands farther off may be another label
    front = _NEAR.findall(_shared([f[::-1] for f in fronts])[::-1])[0]
    back = re.findall(r"^[\W_]*", _shared(backs))[0]
    shape = next((s for s in _SHAPES if all(re.fullmatch(s, v) for v, _ in told)), ".+")
    whole = "^" if front and all(f == front for f in fronts) else ""
    pattern = f"{whole}{_escaped(front)}(?P<{target}>{shape}){_escaped(back)}"
    for (value, _), block in zip(told, blocks, strict=True):
        taken = next((m for m in search(pattern, block.lines[::-1]) if m), None) or {}
        if alike(taken.get(target, "")) != alike(value):
            return Label(pattern, f"it takes {taken.get(target, 'none')!r} for {value!r} of the block that begins at line {block.begins}")
    return Label(pattern)


def _shared(texts: Sequence[str]) -> str:
    """Return what texts share at their beginning."""
    return "".join(c[0] for c in takewhile(lambda c: len(set(c)) == 1, zip(*texts, strict=False)))


def _escaped(text_: str) -> str:
    return re.sub(r"\\([ #,;:%&~=-])", r"\1", re.escape(text_)).replace("\t", r"\t")


def _counts_runs(title: str) -> bool:
    """Return whether a line holds words for runs and nothing else (``Run 1``, ``Latest``)."""
    held = re.findall(r"[^\W\d_]+", title.lower())
    return bool(held) and _RUNS.issuperset(held)


def _titled(blocks: Sequence[Told]) -> tuple[Label, set[str]]:
    """Return a pattern for the titles of blocks, which are lines without a colon or a time, and the labels it gives, by what tells them in names of files."""
    for k in range(1, 1 + min(len(b.lines) for b in blocks)):
        titles = [b.lines[-k] for b in blocks]
        if len(set(titles)) == 1 or any(_NO_TITLE.search(t) or _TIMES.intersection(said(t).words) for t in titles):
            continue
        if all(map(_counts_runs, titles)) or titles == [str(i + 1) for i in range(len(titles))]:
            continue
        named = name_pattern(titles)
        if (labels := {x for x in named.labels if x in LABELS}) and all(search(named.pattern, titles)):
            # of a file's name both would make it, in a line of a block a group around them does
            whole = "location and bend make the configuration: write (?P<config_id>...) around both" if named.constants else ""
            return Label(named.pattern, "; ".join(filter(None, (named.question, whole)))), labels
        if len({re.sub(r"\d+", "0", t) for t in titles}) > 1:
            ask = f"do lines such as '{titles[0][:_SHOWN]}' and '{titles[1][:_SHOWN]}' tell the configuration? If not, take block_lines out"
            return Label(f"(?P<config_id>{_OPEN})", ask), {"config_id"}
    return Label(""), set()

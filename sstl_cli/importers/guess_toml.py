"""The proposed mapping as a TOML text: what is known stands there, what is not ends in ``(?)`` and a question."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.units import is_unit, unit_of
from sstl_cli.importers.guess_blocks import Stacked
from sstl_cli.importers.guess_clocks import SAME_STEP, own_time
from sstl_cli.importers.guess_files import Named, side_words, taken
from sstl_cli.importers.guess_labels import LabelColumn
from sstl_cli.importers.guess_look import Look, moves
from sstl_cli.importers.guess_marks import MANY_N
from sstl_cli.importers.guess_missing import without_code
from sstl_cli.importers.guess_names import Said
from sstl_cli.importers.guess_roles import SIDES, Roles
from sstl_cli.importers.guess_runs import Groups
from sstl_cli.importers.guess_starts import begun_apart
from sstl_cli.importers.guess_time import MARK, TimeGuess
from sstl_cli.importers.guess_words import QUANTITY_OF, UNIT_CELLS
from sstl_cli.importers.systems import SYSTEM_OF

Array = NDArray[np.float64]
HEAD = "# Proposed by sstl import --guess. Complete every line that ends in a question and delete its mark."
# less than the finest tendons, in catheters, are pulled with
FEW_N = 0.05
# of the most negative reading, how far others may lie above zero
SLACK = 0.1
ANY_LENGTH = "no word of its name says position: is it that of the motor, or another length (then leave the line out)?"


@dataclass(frozen=True)
class Pair:
    """Files with the input and as many with the output; the first of each tell the mapping."""

    firsts: tuple[Look, ...]
    seconds: tuple[Look, ...]

    @property
    def first(self) -> Look:
        """The first file with an input."""
        return self.firsts[0]

    @property
    def second(self) -> Look:
        """The first file with an output."""
        return self.seconds[0]

    @property
    def by_folder(self) -> bool:
        """Whether each of several pairs lies in a folder of its own."""
        folders = [[x.path.absolute().parent for x in looks] for looks in (self.firsts, self.seconds)]
        return len(self.firsts) > 1 and len(set(folders[0])) == len(folders[0]) and sorted(folders[0]) == sorted(folders[1])

    @property
    def files(self) -> int:
        """Number of files in all."""
        return len(self.firsts) + len(self.seconds)


@dataclass(frozen=True)
class Proposal:
    """Everything that is written down."""

    format: str
    names: tuple[Said, ...]
    data: dict[str, Array]
    time: TimeGuess
    roles: Roles
    named: Named
    pair: Pair | None
    labels: tuple[LabelColumn, ...] = ()
    runs: str = ""
    own: Mapping[str, TimeGuess] = field(default_factory=dict)
    system: str = ""
    groups: Groups | None = None
    blocks: Stacked | None = None


def written(p: Proposal) -> str:
    """Return the mapping as TOML."""
    lines = [HEAD, f"format = {json.dumps(p.format)}"]
    pattern = p.named.pattern if p.pair is None else _pair_name(p.pair, p.named)
    if pattern:
        lines.append(f"file_name = '{pattern}'" + _mark(p.named.question))
    if p.runs:
        lines.append(f"runs = '{p.runs}'" + _mark(p.groups.question if p.groups is not None else ""))
    lines += _stacked(p.blocks) if p.blocks is not None else []
    files = _files(p.pair) if p.pair else ("", "")
    lines += ["", "[columns]", _with(p.time.line, files[0])]
    for target, file in zip(SIDES, files, strict=True):
        data = p.data if p.pair is None else (p.pair.first if target == "tension_in_n" else p.pair.second).data
        line = _tension(target, p.roles, data)
        if p.pair is not None and target == "tension_out_n":
            clock, (late, question) = p.pair.second.time, _late(p.pair)
            line = _with(line, ", ".join(filter(None, (file, own_time(clock), late))))
            line = asked(asked(line, _clock_question(clock)), question)
        else:
            found = p.roles.of(target)[0]
            line = _on_own_clock(_with(line, file), found[0] if found else None, p)
        lines.append(line)
    lines += _others(p)
    lines += [f"{c.target} = {json.dumps(c.column, ensure_ascii=False)}" + _mark(c.question) for c in p.labels]
    told = {*(c.target for c in p.labels), *(p.groups.labels if p.groups is not None else ())}
    lines += ["", "[constants]"]
    if "system" not in (*p.named.labels, *told):
        named = f"its name says {p.named.way} in other words; " if p.named.way else ""
        said = f"the file says {p.system} itself; " if p.system else named
        lines.append(f'system = "{p.system or p.named.way or _system(p.roles)}"' + _mark(f"{said}act: single pass, sstl: double pass"))
    # without a pattern the question of the names stands where their labels are
    doubt = "" if pattern else p.named.question
    lines += [f"{k} = {json.dumps(v)}" + _mark(doubt) for k, v in p.named.constants if k not in told]
    only_one = any(ask.startswith("only one") for ask in (p.roles.ask_first, p.roles.ask_second))
    if p.pair is not None or only_one:
        lines += ["", "[files]", 'merge = "channels"']
        lines += [f'key = "{"folder" if p.pair.by_folder else "take"}"'] if p.pair is not None and p.pair.files > 2 else []
    lines += _clocks(p.pair) if p.pair is not None else []
    return "\n".join([*lines, ""])


def _stacked(blocks: Stacked) -> list[str]:
    """Return the lines of blocks of one header below each other."""
    patterns = ", ".join(f"'{x.pattern}'" for x in blocks.labels)
    asks = "; ".join(filter(None, (x.question for x in blocks.labels)))
    lines = ["", "[text]", 'blocks = "runs"' + _mark(blocks.question)]
    return [*lines, f"block_lines = [{patterns}]" + _mark(asks)] if patterns else lines


def _system(roles: Roles) -> str:
    """Return the system that the names of both tensions tell (``sstlTin``), ``act`` where they do not: a proposal to be asked."""
    told = [{SYSTEM_OF[w] for w in s.words if w in SYSTEM_OF} for s in (*roles.first, *roles.second)]
    return next(iter(told[0])) if told and len(told[0]) == 1 and all(t == told[0] for t in told) else "act"


def _tension(target: str, roles: Roles, data: dict[str, Array]) -> str:
    found, question = roles.of(target)
    if not found:
        tail = ' , file = "NAME"' if question.startswith("only one") else ""
        return f'{target} = {{ column = "...", unit = "N"{tail} }}'.replace(" ,", ",") + _mark(question or "which channel?")
    one = found[0]
    names = [json.dumps(s.name, ensure_ascii=False) for s in found]
    source = f"minus = [{', '.join(names)}]" if len(found) > 1 else f"column = {names[0]}"
    held = [without_code(data[s.name]) for s in found]
    unit, doubt = _unit(one, target, [values for values, _, _ in held])
    if len(found) == 1 and one.dimension in ("", "force") and not one.strange and negative(held[0][0]):
        unit, turned = f"{unit}, sign = -1", "negative throughout, and a tendon only pulls: does it read negative in tension?"
        doubt = "; ".join(filter(None, (turned, doubt)))
    codes = (
        f"{n} samples hold {code:g}, a code for a missing reading? leave these cells empty then" for _, code, n in held if code is not None
    )
    return f"{target} = {{ {source}, {unit} }}" + _mark("; ".join(filter(None, (question, doubt, *codes, *(s.doubt for s in found)))))


def negative(values: Array) -> bool:
    """Return whether readings lie below zero, but for a slack tendon's noise around it."""
    finite = values[np.isfinite(values)]
    return bool(len(finite)) and float(finite.max()) < -SLACK * float(finite.min())


def _unit(one: Said, target: str, values: list[Array]) -> tuple[str, str]:
    """Return the unit part of a source and the question that it leaves."""
    finite = np.concatenate([v[np.isfinite(v)] for v in values])
    whole = bool(len(finite)) and bool(np.all(finite == np.round(finite)))
    most = float(np.abs(finite).max()) if len(finite) else 0.0
    if one.strange:
        return (
            f"unit = {json.dumps(one.strange, ensure_ascii=False)}",
            f'{one.strange} is no force: define it in [units], such as {json.dumps(one.strange, ensure_ascii=False)} = "0.5 N"',
        )
    if one.dimension == "force":
        return f'unit = "{one.unit}"', _force_doubt(one, whole, most)
    if one.dimension in ("voltage", "count"):
        per = "V" if one.dimension == "voltage" else "count"
        return f'unit = "{one.unit}"', f"{one.unit} need gain = N per {per}, and offset = the reading at no load"
    if one.dimension == "pressure":
        return f'unit = "{one.unit}"', "a pressure needs bore_mm or area_mm2"
    if one.unit:
        return f'unit = "{one.unit}", as = "N"', f'a {one.dimension} in {one.unit}, no tension: as = "N" keeps its numbers'
    if one.name == target:
        return 'unit = "N"', ""
    if ending := _ending(one.name):
        return f'unit = "{ending}"', f"its name ends in {ending}: is that its unit (values up to {most:.4g})?"
    if whole and most > 50:
        return 'unit = "counts"', f"no unit is stated, whole numbers up to {most:g}: counts need gain = N per count"
    return 'unit = "N"', f"no unit is stated (values up to {most:.4g}): N, or V, counts, lbf, kgf?"


def _force_doubt(one: Said, whole: bool, most: float) -> str:
    """Return the question of readings up to ``most`` in a unit of force, whole numbers or not, an empty text where they leave none."""
    if whole and most > 1000 and one.unit in ("N", "mN", "kN", "gf", "g"):
        return f"whole numbers up to {most:g}: counts (then a gain), or {one.unit}?"
    if one.unit == "g" and not any(QUANTITY_OF.get(w) == "force" or w in ("f", "t") for w in one.words):
        return "no word of its name says force: grams of a load, or an acceleration?"
    if one.unit == "N" and most > MANY_N:
        return f"up to {most:.4g} N: is the unit right?"
    if 0.0 < (newtons := most * unit_of(one.unit)[1]) < FEW_N:
        return f"up to {newtons:.2g} N, less than a tendon's: is the unit right, and is its mark not one between thousands?"
    return ""


def _ending(name: str) -> str:
    """Return the unit of force at the end of a name that is not sure to be one (``tip_g``, ``Fout_G``), an empty text where none stands there."""
    last = re.split(r"[_ .]", name)[-1]
    unit = next((u for u in (last, last.lower(), UNIT_CELLS.get(last.lower(), "")) if is_unit(u)), "")
    return unit if last != name and unit and unit_of(unit)[0] == "force" else ""


def _others(p: Proposal) -> list[str]:
    """Return lines for the proximal displacement and the reference where they are sure or asked, else comments."""
    used = {s.name for s in (*p.roles.first, *p.roles.second)} | {p.time.channel}
    free = [(s, p.data.get(s.name, np.empty(0))) for s in p.names if s.name not in used]
    # what stays where it is over a file is a dimension of the rig
    places = [
        s
        for s, v in free
        if s.quantity == "position" and s.dimension != "time" and not (s.reference or s.unmeasured) and s.side != "out" and moves(v)
    ]
    places = [s for s in places if s.placed] or places
    references = [(s, v) for s, v in free if s.reference and (s.quantity == "force" or s.dimension == "force")]
    lines = []
    for s in places:
        sure = len(places) == 1 and s.dimension == "length" and p.pair is None
        lines.append(_on_own_clock(_other("position_in_mm", s, sure, "" if s.placed else ANY_LENGTH), s, p))
    for s, v in references:
        sure = len(references) == 1 and s.dimension == "force" and p.pair is None and not negative(v)
        lines.append(_on_own_clock(_other("tension_ref_n", s, sure), s, p))
    return lines


def _other(target: str, one: Said, sure: bool, question: str = "") -> str:
    line = f'{target} = {{ column = {json.dumps(one.name, ensure_ascii=False)}, unit = "{one.unit or "..."}" }}'
    return line + _mark("; ".join(filter(None, (question, one.doubt)))) if sure else f"# {line}"


def _mark(question: str) -> str:
    return MARK + question if question else ""


def _with(line: str, extra: str) -> str:
    """Return a line of [columns] with more keys in its table."""
    return line.replace(" }", f", {extra} }}", 1) if extra else line


def _files(pair: Pair) -> tuple[str, str]:
    """Return ``file = "..."`` for either side: what only its names have."""
    first, second = pair.first.path.name, pair.second.path.name
    out = []
    for mine, other in ((first, second), (second, first)):
        words = [w for w in re.findall(r"[A-Za-z]+|\d+", mine) if w not in re.findall(r"[A-Za-z]+|\d+", other)]
        word = next((w for w in side_words([mine]) if w in words), words[0] if words else mine)
        out.append(f"file = {json.dumps(re.escape(mine) if word == mine or word.isdigit() else _alone(word))}")
    return out[0], out[1]


def _alone(word: str) -> str:
    """Return a pattern for a word that is not part of a longer one (``in`` in ``line``)."""
    # RE2 does not look around
    return f"(?:^|[^A-Za-z]){word}(?:[^A-Za-z]|$)"


def _on_own_clock(line: str, one: Said | None, p: Proposal) -> str:
    """Return the line of a channel with the clock that it has in a file with several."""
    clock = p.own.get(one.name) if one is not None else None
    return line if clock is None else asked(_with(line, own_time(clock)), _clock_question(clock))


def asked(line: str, question: str) -> str:
    """Return a line with a question behind those that it has."""
    if not question:
        return line
    return f"{line}; {question}" if MARK in line else line + _mark(question)


def _clock_question(clock: TimeGuess) -> str:
    """Return the question that the own clock of the output leaves."""
    question = clock.line.partition(MARK)[2]
    return f"its time: {question}" if question else ""


def _clocks(pair: Pair) -> list[str]:
    """Return how the clocks of two files may meet, where nothing says that they have one zero; it must be asked."""
    held = [(_seconds(a), _seconds(b)) for a, b in zip(pair.firsts, pair.seconds, strict=True)]
    known = [(x, y) for x, y in held if x is not None and y is not None]
    if not known or _late(pair)[1]:
        return []
    how = '"start" if both recorders began together, "apply" to find it by the motion'
    if any(np.nanmin(x) > np.nanmax(y) or np.nanmin(y) > np.nanmax(x) for x, y in known):
        # unix time beside one from 0 s
        return ["", "[clocks]", 'align = "start"' + _mark(f"the clocks never meet: {how}")]
    if any(_zeros_of_their_own(x, y) for x, y in known):
        return ["", "[clocks]", 'align = "start"' + _mark(f"each file's clock begins at a zero of its own, and their stamps differ: {how}")]
    return []


def _late(pair: Pair) -> tuple[str, str]:
    """Return the offset of the output's clock where lines above the tables say that it began at another time than its stamps do, and what is to be asked."""
    found: list[tuple[float, str]] = []
    for x, y in zip(pair.firsts, pair.seconds, strict=True):
        apart, said = begun_apart(x.beside.starts, y.beside.starts)
        clocks = _seconds(x), _seconds(y)
        if apart and clocks[0] is not None and clocks[1] is not None:
            # clocks of one zero tell it themselves, to what the header shows of a second
            own = float(clocks[1][0] - clocks[0][0])
            found += [(apart, f"headers begin {abs(apart):g} s apart ({said})")] if abs(apart - own) > abs(own) else []
    if not found:
        return "", ""
    apart, said = found[0]
    if len(pair.firsts) > 1:
        return "", f"{said}: does each clock count from there? then each pair needs a time_offset, in a mapping of its own"
    size = re.search(r"scale = ([^ ,}]+)", pair.second.time.line)
    unit = re.search(r'unit = "(\w+)"', pair.second.time.line)
    raw = apart / (unit_of(unit[1])[1] if unit else 1.0) / (float(size[1]) if size else 1.0)
    ask = f"{said}: does each clock count from there, as time_offset says? If both have one zero, take it out"
    return f"time_offset = {-raw:.9g}", ask


def _seconds(look: Look) -> Array | None:
    """Return the clock of a file in s, None where no channel tells it."""
    unit = re.search(r'unit = "(\w+)"', look.time.line)
    return look.data[look.time.channel] * unit_of(unit[1])[1] if look.time.channel is not None and unit is not None else None


def _zeros_of_their_own(x: Array, y: Array) -> bool:
    """Return whether two clocks each begin at 0 and do not hold the same numbers, which one recorder would have written for both."""
    steps = [float(np.nanmedian(np.diff(v))) for v in (x, y)]
    begin = all(abs(v[0]) < step for v, step in zip((x, y), steps, strict=True))
    return begin and not (len(x) == len(y) and bool(np.max(np.abs(x - y)) <= SAME_STEP * steps[0]))


def _pair_name(pair: Pair, named: Named) -> str:
    """Return the pattern for the labels, and for what tells which files belong together where there are several pairs."""
    if (pair.files <= 2 or pair.by_folder) and not named.pattern:
        return ""
    sides = side_words([pair.first.path.stem, pair.second.path.stem])
    words, body = "|".join(sides), named.pattern.removeprefix("^")
    if taken(pair.first.path.stem, sides)[1]:
        return rf"^(?:{words})[-_ ]*(?P<take>{body}.*)\."
    # RE2 does not look ahead
    return rf"^(?P<take>{body}.*?)[-_ ]*(?:{words})(?:[^A-Za-z]|$)"

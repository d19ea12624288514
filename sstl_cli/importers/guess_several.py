"""Several files in one proposal: what is right for the first must be right for all, or its line names the file that differs."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence

import numpy as np

from sstl_cli.importers.guess_files import Named, label_words
from sstl_cli.importers.guess_labels import LabelColumn
from sstl_cli.importers.guess_look import Look
from sstl_cli.importers.guess_remarks import SHOWN, alike, is_radius
from sstl_cli.importers.guess_time import MARK
from sstl_cli.importers.guess_toml import Pair, Proposal, asked, written
from sstl_cli.importers.pattern import search
from sstl_cli.importers.systems import known_system

# typical steps of two clocks without a stated unit that are this far apart may be counted in different ones
STEP_RATIO = 5.0
# values of a column that a question names
_HELD = 2


def with_doubts(toml: str, look: Look, looks: Sequence[Look]) -> str:
    """Return a proposal for files of the same channels, whose lines ask where the file of another would say something else."""
    return _asking(toml, _differing(look, looks))


def with_doubts_of_pairs(toml: str, pair: Pair) -> str:
    """Return the same for several pairs: inputs are compared with the first input, outputs with the first output."""
    first = _differing(pair.first, pair.firsts)
    second = _differing(pair.second, pair.seconds)
    # the clock of an output stands in the line of its tension
    output = "; ".join(filter(None, (second.get("tension_out_n"), second.get("time_s"))))
    doubts = {"time_s": first.get("time_s", ""), "tension_in_n": first.get("tension_in_n", ""), "tension_out_n": output}
    return _asking(toml, doubts)


def with_doubt_of_system(toml: str, looks: Sequence[Look]) -> str:
    """Return a proposal that asks for the system where a file says another one than its name does."""
    pattern = re.search(r"^file_name = '(.*?)'", toml, re.MULTILINE)
    constant = re.search(r'^system = "(act|sstl)"$', toml.partition("[constants]")[2], re.MULTILINE)
    for look in looks:
        column = next((c for c in look.labels if c.target == "system"), None)
        found = search(pattern[1], [look.path.name])[0] if pattern else None
        told = constant[1] if constant else known_system((found or {}).get("system", ""))
        if told and column is not None and column.systems != {told}:
            held = " and ".join(sorted(column.systems))
            return _asking(toml, {"system": f"the name of '{look.path.name}' says {told}, this column {held}: which is right?"})
        if told and column is None and look.beside.system not in ("", told):
            ask = f"the name of '{look.path.name}' says {told}, the file itself {look.beside.system}: which is right?"
            if constant or len(looks) > 1:
                return _asking(toml, {"system" if constant else "file_name": ask})
            # a constant goes before what the name says
            return toml.replace("[constants]\n", f'[constants]\nsystem = "{told}"{MARK}{ask}\n', 1)
    return _asking(toml, {"system": next((x.beside.both for x in looks if not _gives_system(x)), "") or _both_systems(looks)})


def _gives_system(look: Look) -> bool:
    """Return whether a column or the names of groups give the system of each run of a file."""
    return any(c.target == "system" for c in look.labels) or (look.groups is not None and "system" in look.groups.labels)


def _both_systems(looks: Sequence[Look]) -> str:
    """Return what is to be asked of files without a column for it that state both systems themselves, an empty text where they do not."""
    told = {look.beside.system: look.path.name for look in looks if look.beside.system and not _gives_system(look)}
    says = " and ".join(f"'{name}' says {system}" for system, name in sorted(told.items()))
    return f"{says}: give the system of each by a manifest (--manifest), and take this out" if len(told) > 1 else ""


def with_bend(toml: str, looks: Sequence[Look]) -> str:
    """Return a proposal that asks for the configuration where files tell it beside their tables, and their names another one or none."""
    said = {look.beside.bend[0]: look for look in looks if look.beside.bend[0]}
    pattern = re.search(r"^file_name = '(.*?)'", toml, re.MULTILINE)
    named = {x.path.name: (search(pattern[1], [x.path.name])[0] or {}).get("config_id", "") if pattern else "" for x in looks}
    columns = [(look, c) for look in looks for c in look.labels if c.target == "config_id"]
    if columns:
        return _asking(toml, {"config_id": _against_name(columns, named)})
    # names of groups are no lines beside the runs that they hold
    if not said or any(look.groups is not None and "config_id" in look.groups.labels for look in looks):
        return toml
    if all(alike(named[look.path.name]) == alike(look.beside.bend[0]) for look in looks):
        return toml
    lines = " and ".join(
        f"'{look.beside.bend[1] if look.beside.bend[0] == '...' else look.beside.bend[1][:SHOWN]}' in '{look.path.name}'"
        for look in list(said.values())[:2]
    )
    if any(named.values()) or re.search("^config_id = ", toml, re.MULTILINE):
        if all(is_radius(look.beside.bend[1]) for look in said.values()):
            # that of a spool, or of the same bend
            return toml
        target = "config_id" if re.search("^config_id = ", toml, re.MULTILINE) else "file_name"
        return _asking(toml, {target: f"{lines}: which tells the configuration, this or the name?"})
    one = len(said) == 1 and all(look.beside.bend[0] for look in looks)
    ask = (
        f"{lines} differ: which is the bending configuration? If these are runs of several, split the file there"
        if one and "..." in said
        else f"{lines}: the bending configuration?"
        if one
        else f"{lines}: give the configuration of each by a manifest (--manifest), and take this out"
    )
    value = json.dumps(next(iter(said)) if one else "...", ensure_ascii=False)
    return toml.replace("[constants]\n", f"[constants]\nconfig_id = {value}{MARK}{ask}\n", 1)


def _against_name(columns: Sequence[tuple[Look, LabelColumn]], named: Mapping[str, str]) -> str:
    """Return what is to be asked where the name of a file tells another bend than its column holds, an empty text where none does."""
    for look, column in columns:
        name = named[look.path.name]
        # a number without a word for a bend may count files
        if "config_id" in label_words([look.path.stem]) and name and alike(name) not in map(alike, column.held):
            held = " and ".join(sorted(column.held)[:_HELD])
            return f"the name of '{look.path.name}' says {name}, this column {held}: which tells the configuration?"
    return ""


def _asking(toml: str, doubts: dict[str, str]) -> str:
    lines = [asked(line, doubts.get(line.partition(" = ")[0], "")) for line in toml.split("\n")]
    return "\n".join(lines)


def _differing(look: Look, looks: Sequence[Look]) -> dict[str, str]:
    """Return a question for each line of the proposal for one file that another would have otherwise."""
    mine = _columns(look)
    doubts: dict[str, str] = {}
    for other in looks:
        theirs = _columns(other)
        for target, line in mine.items():
            body, _, question = line.partition(MARK)
            there, _, asks = theirs.get(target, "").partition(MARK)
            if not there and target == "position_in_mm" and set(look.channels) <= set(other.channels):
                # it stays where it is in that file
                continue
            if there != body:
                doubts.setdefault(target, f"'{other.path.name}' gives {there.partition(' = ')[2] or 'none'}: it needs a mapping of its own")
            elif asks and not question:
                doubts.setdefault(target, f"in '{other.path.name}': {asks}")
        if other.time.channel == look.time.channel and not _stated(look) and _far(look, other):
            what = f"its step is {_step(other):g} in '{other.path.name}' and {_step(look):g} here"
            doubts.setdefault("time_s", f"{what}: another unit, which needs a mapping of its own?")
    return doubts


def _columns(look: Look) -> dict[str, str]:
    """Return the lines of [columns] that one file alone would have, by what they give."""
    toml = written(Proposal(look.format.ID, look.names, look.data, look.time, look.roles, Named(), None, look.labels, look.runs, look.own))
    body = toml.partition("[columns]\n")[2].partition("\n\n")[0]
    return {line.partition(" = ")[0]: line for line in body.split("\n") if not line.startswith("#")}


def _stated(look: Look) -> bool:
    """Return whether the clock's own name or the file states its unit."""
    return any(s.name == look.time.channel and s.dimension == "time" for s in look.names)


def _step(look: Look) -> float:
    steps = np.diff(look.data.get(look.time.channel or "", np.empty(0)))
    steps = steps[steps > 0]
    return float(np.median(steps)) if len(steps) else 0.0


def _far(look: Look, other: Look) -> bool:
    low, high = sorted((_step(look), _step(other)))
    return low > 0 and high >= STEP_RATIO * low

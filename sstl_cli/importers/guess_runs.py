"""Groups of a file that each hold a whole run: the pattern of all, and the labels that their names tell."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from sstl_cli.importers.base import Channel
from sstl_cli.importers.guess_files import Named, name_pattern
from sstl_cli.importers.guess_names import RUN_IN_FRONT, said
from sstl_cli.importers.mapping import LABELS
from sstl_cli.importers.pattern import search, starts

_PARTS = re.compile(r"[A-Za-z]+|\d+|[^A-Za-z\d]+")
_DATED = re.compile(r"\D{0,8}(?:19|20)\d\d\D?\d\d\D?\d\d(?!\d{3})|\D{0,8}\d\d\D\d\d\D(?:19|20)\d\d")
_SHOWN = 3


@dataclass(frozen=True)
class Groups:
    """What stands in front of the channels of the first run, the pattern of all, the labels it gives, a question, and one for each channel whose unit differs."""

    prefix: str
    pattern: str
    labels: tuple[str, ...] = ()
    question: str = ""
    doubts: Mapping[str, str] = field(default_factory=dict)


def runs_by_group(found: Sequence[Channel], table: bool = False) -> Groups | None:
    r"""Return the groups that each hold both sides of a run, None where fewer than two do, or they are sides or tendons themselves.

    Parameters
    ----------
    found : sequence of Channel
        The channels of a file.
    table : bool
        Whether they are columns of one table, which stand in groups by a run in front of a colon and have a clock in each.

    Examples
    --------
    >>> held = [Channel(f"run{k}/{name}") for k in (1, 2) for name in ("time", "fin", "fout")]
    >>> runs_by_group(held).pattern, runs_by_group(held[:3]), runs_by_group(held[:5]).question
    ('run\\d+/', None, "'run2' lacks a tension that others hold and is left out")
    >>> runs_by_group([Channel(f"Run {k}: {name}") for k in (1, 2) for name in ("Time (s)", "Fin (N)", "Fout (N)")], table=True).pattern
    'Run \\d+: '
    """
    mark = next((m for m in ((": ", ":") if table else "/.") if any(m in c.name for c in found)), "" if table else "_")
    if not mark:
        return None
    units: dict[str, dict[str, str]] = {}
    for one in found:
        head, sep, tail = _cut(one.name, mark)
        if sep and not one.text and not tail.startswith("@"):
            units.setdefault(head + sep, {})[tail] = one.unit
    if mark == "_" or table:
        # F1_in and F1_out are no run without a clock of their own
        units = {h: own for h, own in units.items() if any(said(t).quantity == "time" for t in own)}
    forces = {h: {t for t in own if said(t).tension} for h, own in units.items()}
    whole = sorted(h for h, held in forces.items() if {said(t).side for t in held} >= {"in", "out"})
    # T_in of motor and tip: the groups are sides of one run
    if not whole or {said(h).side for h in whole} & {"in", "out"} or any(forces[h] != forces[whole[0]] for h in whole):
        return None
    lack = [h.removesuffix(mark) for h in sorted(forces) if h not in whole and forces[h] and forces[h] < forces[whole[0]]]
    if len(whole) + len(lack) < 2:
        return None
    pattern, labels, question = _pattern([h.removesuffix(mark) for h in whole], mark, [c.name for c in found])
    pattern = pattern.replace("\\ ", " ")
    if all(RUN_IN_FRONT.fullmatch(h) for h in whole):
        # Run 1, Run 2, Latest
        question = ""
    if lack:
        question = "; ".join(
            filter(None, (question, f"{', '.join(map(repr, lack[:_SHOWN]))} lacks a tension that others hold and is left out"))
        )
    first = units[whole[0]]
    doubts = {
        t: f"'{h}{t}' is in {units[h][t] or 'no unit that is stated'}, this one in {first[t] or 'none'}: it needs a mapping of its own"
        for h in reversed(whole[1:])
        for t in first
        if t in units[h] and units[h][t] != first[t]
    }
    return Groups(whole[0], pattern, labels, question, doubts)


def named_in_runs(pattern: str, names: Sequence[str], tail: str) -> list[str]:
    """Return the channels that have a name behind what a pattern of runs matches."""
    return [n for n, start in zip(names, starts(pattern, names), strict=True) if start and n == start + tail] if pattern else []


def _cut(name: str, mark: str) -> tuple[str, str, str]:
    """Return the group of a channel, the mark behind it, and the channel's own name; of ``run01_fin_N`` the group ends in a number."""
    if mark != "_":
        return name.rpartition(mark)
    found = re.match(r"([A-Za-z_]*\d+)(_)(.+)", name)
    return (found[1], found[2], found[3]) if found else ("", "", name)


def _pattern(heads: list[str], mark: str, names: list[str]) -> tuple[str, tuple[str, ...], str]:
    """Return the pattern that fits some groups and nothing else, the labels that it gives, and the question that they leave."""
    cut = [_PARTS.findall(h) for h in heads]
    if len({tuple(p[0].isdigit() + 2 * p[0].isalpha() for p in parts) for parts in cut}) == 1:
        named = Named() if len(heads) == 1 or all(map(_DATED.match, heads)) else name_pattern(heads)
        told = [m or {} for m in search(named.pattern, heads)] if named.pattern else []
        columns = list(zip(*cut, strict=True))
        body, labels = [], []
        for values in columns:
            label = next((k for k in LABELS if told and k not in labels and [m.get(k) for m in told] == list(values)), "")
            kind = r"\d+" if values[0].isdigit() else "[A-Za-z]+" if values[0].isalpha() else ""
            # numbers go on in the next file
            shape = kind if kind and (label or len(set(values)) > 1 or (values[0].isdigit() and len(heads) > 1)) else re.escape(values[0])
            body.append(f"(?P<{label}>{shape})" if label else shape)
            labels += [label] if label else []
        pattern = "".join(body) + re.escape(mark)
        # a calibration beside the runs is none
        heads_of = [_cut(n, mark)[0] for n in names]
        if [s for s in starts(pattern, names) if s] == [h + mark for h in heads_of if h in heads] and all(
            len(set(values)) == 1 or values[0].isalnum() for values in columns
        ):
            return pattern, tuple(labels), named.question
    pattern = f"(?:{'|'.join(map(re.escape, heads))}){re.escape(mark)}"
    shown = ", ".join(heads[:_SHOWN])
    return (
        pattern,
        (),
        f"do the groups ({shown}{', ...' if heads[_SHOWN:] else ''}) tell configurations? then name a part of the pattern (?P<config_id>...)",
    )

"""A proposed mapping for unknown recordings: what each channel seems to be, why, and a preview loop."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.base import Layout, detect
from sstl_cli.importers.finder import Recording
from sstl_cli.importers.guess_blocks import of_all
from sstl_cli.importers.guess_dropouts import with_dropouts
from sstl_cli.importers.guess_files import Named, name_pattern, shared_labels, side_of, side_words, taken
from sstl_cli.importers.guess_folders import with_folders
from sstl_cli.importers.guess_left import not_mapped
from sstl_cli.importers.guess_look import Look, look_at, moves
from sstl_cli.importers.guess_marks import asking
from sstl_cli.importers.guess_names import Said, said
from sstl_cli.importers.guess_roles import Roles, doubted
from sstl_cli.importers.guess_several import with_bend, with_doubt_of_system, with_doubts, with_doubts_of_pairs
from sstl_cli.importers.guess_toml import Pair, Proposal, written
from sstl_cli.importers.mapping import REQUIRED, Question, open_questions
from sstl_cli.importers.rows import JoinedRows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Guess:
    """A mapping to be edited, with its reasons, the questions that are left and a preview of the loop."""

    format: str
    toml: str
    reasons: list[str]
    preview: list[str]
    questions: list[Question]


def guess(paths: list[Path], wanted: str | None = None) -> Guess:
    """Return a proposed mapping from names, units and the first 20 000 samples of recordings of one kind.

    Raises
    ------
    SstlError
        If no file can be read, or the files hold fewer than two numeric channels.
    """
    looks, reasons = _looks(paths, wanted)
    kinds = Counter(look.channels for look in looks)
    pair = _pair(looks) if len(looks) > 1 else None
    if pair is not None:
        reasons.append(f"'{pair.first.path.name}' holds the input and '{pair.second.path.name}' the output: merge = \"channels\"")
        look, first, second = pair.first, pair.first.roles, pair.second.roles
        roles = Roles(first.first, second.second, first.ask_first, second.ask_second)
        reasons += [*pair.second.time.reasons]
    else:
        most = kinds.most_common(1)[0][0]
        look = next(x for x in looks if x.channels == most)
        roles = look.roles
        for other in looks:
            if not look.used <= set(other.channels):
                reasons.append(f"'{other.path.name}' has other channels ({', '.join(other.channels[:6])}): not covered")
    reasons += [*look.time.reasons, *roles.reasons]
    if all(n in look.channels for n in REQUIRED):
        reasons.append("the columns are canonical: no mapping is needed")
    rows = isinstance(look.format, JoinedRows)
    stems = [p.stem for p in paths]
    # of rows side by side the names of the files are those of the channels
    own = _pair_labels(looks, pair) if pair is not None else shared_labels(stems) if rows else name_pattern(stems)
    named = own if rows else with_folders(own, paths)
    if named.reason:
        reasons.append(named.reason)
    toml = written(
        Proposal(
            "npz" if rows else look.format.ID,
            look.names,
            look.data,
            look.time,
            roles,
            named,
            pair,
            look.labels,
            look.runs,
            look.own,
            look.beside.system,
            look.groups,
            of_all([(x.path, x.blocks) for x in looks]),
        )
    )
    toml = toml + '\n[files]\nmerge = "rows"\n' if rows else toml
    toml, why = with_dropouts(toml, look) if pair is None else (toml, ())
    reasons += why
    # an import reads every file that has the columns, whatever else it has
    covered = [x for x in looks if look.used <= set(x.channels)]
    toml = with_doubts(toml, look, covered) if pair is None else with_doubts_of_pairs(toml, pair)
    used = covered if pair is None else [*pair.firsts, *pair.seconds]
    toml = with_bend(with_doubt_of_system(toml, used), used)
    reasons += not_mapped([look] if pair is None else [pair.first, pair.second], toml)
    return Guess(look.format.ID, toml, list(dict.fromkeys(reasons)), _preview(look, roles, pair), open_questions(toml))


def _looks(paths: list[Path], wanted: str | None) -> tuple[list[Look], list[str]]:
    looks: list[Look] = []
    bad: list[SstlError] = []
    for path in paths:
        try:
            looks.append(look_at(path, wanted))
        except SstlError as error:
            bad.append(error)
    if not looks:
        joined = _joined(paths, wanted) if len(paths) > 1 and all(e.code == "E333" for e in bad) else None
        if joined is None:
            raise bad[0]
        return [joined], [f'{len(paths)} files of one channel each and as many rows: merge = "rows", if row n of each is one sample']
    first = looks[0]
    reasons = [f"format {first.format.ID}: {first.format.TITLE}, {len(first.names)} numeric channels"]
    return looks, [*reasons, *(f"not looked at: {e.line()}" for e in bad)]


def _joined(paths: list[Path], wanted: str | None) -> Look | None:
    """Return what arrays of one channel each hold side by side, None where they are no input and output, or not of one length."""
    formats = [detect(p, wanted) for p in paths]
    parts = [Recording(p, f, tuple(f.channels(p, Layout())), Layout()) for p, f in zip(paths, formats, strict=True)]
    if {f.ID for f in formats} != {"npz"} or any(len(p.channels) != 1 for p in parts):
        return None
    try:
        look = look_at(paths[0], None, JoinedRows(tuple(parts)))
    except SstlError:
        return None
    return look if look.roles.first and look.roles.second else None


def _pair(looks: list[Look]) -> Pair | None:
    """Return the files that hold the input and the output, where each holds one side only."""
    if (two := _unsided(looks)) is not None:
        return two
    sides: dict[str, list[Look]] = {"in": [], "out": []}
    for look in looks:
        side = side_of(look.path.stem)
        many = look.tensions or (*look.roles.first, *look.roles.second) or (_only_channel(look) if side else ())
        if len(many) == 1:
            side = many[0].side or side
        if not side or not many or any(s.side not in ("", side) for s in many) or (not look.tensions and len(many) > 1):
            return None
        sides[side].append(replace(look, roles=_one_side(many, side, look.data)))
    if not sides["in"] or len(sides["in"]) != len(sides["out"]):
        return None
    return Pair(tuple(sides["in"]), tuple(sides["out"]))


def _unsided(looks: list[Look]) -> Pair | None:
    """Return two files of one tension each whose names say no side (``F0001CH1``, ``F0001CH2``): which holds the input is asked."""
    held = [look.tensions or _only_channel(look) for look in looks]
    if len(looks) != 2 or any(len(many) != 1 or many[0].side or side_of(x.path.stem) for many, x in zip(held, looks, strict=True)):
        return None
    moved = [float(np.nanmax(v) - np.nanmin(v)) for x, (one,) in zip(looks, held, strict=True) if len(v := x.data[one.name])]
    # the side that pulls moves more against friction
    order = (1, 0) if len(moved) == 2 and moved[1] > moved[0] else (0, 1)
    first, second = (replace(looks[i], roles=_one_side(held[i], side, looks[i].data)) for i, side in zip(order, ("in", "out"), strict=True))
    asks = [
        f"no name says a side: is '{x.path.name}' the {side}, of the same recording?" for x, side in ((first, "input"), (second, "output"))
    ]
    first = replace(first, roles=replace(first.roles, ask_first="; ".join(filter(None, (asks[0], first.roles.ask_first)))))
    second = replace(second, roles=replace(second.roles, ask_second="; ".join(filter(None, (asks[1], second.roles.ask_second)))))
    return Pair((first,), (second,))


def _only_channel(look: Look) -> tuple[Said, ...]:
    """Return the one channel that moves beside the clock where it may be a tension (``data``, ``col2``), which is asked where the file's name is none of a force."""
    moving = [
        s for s in look.names if s.name in look.data and s.name not in (look.time.channel, look.time.fraction) and moves(look.data[s.name])
    ]
    if len(moving) != 1 or moving[0].quantity or moving[0].reference or moving[0].dimension not in ("", "voltage", "count"):
        return ()
    named = said(look.path.stem).quantity == "force"
    return (moving[0] if named else asking(moving[0], "is this a tension?"),)


def _one_side(many: tuple[Said, ...], side: str, data: dict[str, Array]) -> Roles:
    """Return the tension of a file that holds one side; of several, as the axes of a force sensor, the one that moves most is asked."""
    one = max(many, key=lambda s: float(np.nanmax(data[s.name]) - np.nanmin(data[s.name])))
    others = ", ".join(repr(s.name) for s in many if s is not one)
    ask = doubted((one,), f"it moves most: is it the tendon's, or {others}?" if others else "")
    return Roles(first=(one,), ask_first=ask) if side == "in" else Roles(second=(one,), ask_second=ask)


def _pair_labels(looks: list[Look], pair: Pair) -> Named:
    """Return what the names of pairs say besides the side."""
    if pair.by_folder:
        return shared_labels([pair.first.path.stem, pair.second.path.stem])
    sides = side_words([pair.first.path.stem, pair.second.path.stem])
    shared = sorted({taken(x.path.stem, sides)[0] for x in looks}) if sides else []
    named = name_pattern(shared, takes=True) if shared and all(shared) else Named()
    # F_in_act_bend60 and F_out_act_bend60: of one pair what stands behind the side holds for both
    return named if named.labels or pair.files > 2 else shared_labels([pair.first.path.stem, pair.second.path.stem])


def _preview(look: Look, roles: Roles, pair: Pair | None) -> list[str]:
    # row n of two clocks is no sample of one loop
    if pair is not None or not roles.first or not roles.second or any(s.name in look.own for s in (*roles.first, *roles.second)):
        return []
    names = [[s.name for s in many] for many in (roles.first, roles.second)]
    values = [look.data[n[0]] - look.data[n[1]] if len(n) == 2 else look.data[n[0]] for n in names]
    if len(values[0]) != len(values[1]):
        return []
    drawn = loop(values[0], values[1])
    return [f"{' - '.join(names[1])} (up) over {' - '.join(names[0])} (right):", *drawn] if drawn else []


def loop(x: Array, y: Array, columns: int = 56, rows: int = 16) -> list[str]:
    """Return a plot of ``y`` over ``x`` in Braille dots, as lines of text."""
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good], y[good]
    if not len(x) or np.ptp(x) == 0 or np.ptp(y) == 0:
        return []
    across = np.minimum((x - x.min()) / np.ptp(x) * (2 * columns), 2 * columns - 1).astype(int)
    up = np.minimum((y.max() - y) / np.ptp(y) * (4 * rows), 4 * rows - 1).astype(int)
    dots = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
    cells = np.zeros((rows, columns), int)
    np.bitwise_or.at(cells, (up // 4, across // 2), dots[up % 4, across % 2])
    lines = ["".join(chr(0x2800 + c) for c in row) for row in cells]
    return [*lines, f"x {x.min():.4g} to {x.max():.4g}, y {y.min():.4g} to {y.max():.4g}"]

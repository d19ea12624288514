"""What a file tells beside its readings of system, bend and start: lines, properties, groups, single texts, and columns that hold one word throughout."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from sstl_cli.importers.base import Channel, Format, guarded
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.guess_remarks import bend_said, both_said, system_said
from sstl_cli.importers.guess_starts import starts_said
from sstl_cli.importers.guess_words import words
from sstl_cli.importers.rates_said import LONGEST

PASSES = words("pass passes")


@dataclass(frozen=True)
class Beside:
    """The system (empty: none, or both), what says that both are held, the bend with the line that tells it, and the starts by their names."""

    system: str = ""
    both: str = ""
    bend: tuple[str, str] = ("", "")
    starts: Mapping[str, str] = field(default_factory=dict)


def told_beside(
    chosen: Format, path: Path, found: Sequence[Channel], told: Collection[str], table: bool, texts: Callable[[str], list[str]]
) -> Beside:
    """Return what a file tells beside its readings and its labels.

    Parameters
    ----------
    chosen : Format
        Its format.
    path : Path
        The file.
    found : sequence of Channel
        Its channels.
    told : collection of str
        Those that give labels.
    table : bool
        Whether it is a table, whose columns have names without a path.
    texts : callable
        The first values of a channel as text.
    """
    with guarded(path, chosen.TITLE):
        lines = remarks_of(chosen, path)
    single = [c.name for c in found if c.text and c.rows == 1 and c.name not in told]
    if not table:
        lines += dict.fromkeys(parts[0] for c in found if len(parts := re.split("[./]", c.name)) > 1)
    lines += [f"{re.split('[./]', n)[-1]}: {t}" for n in single for t in texts(n)]
    # who tells a bend needs no more, and a pattern takes its time with a line of blanks
    lines = [x[:LONGEST] for x in lines]
    within = getattr(chosen, "remarks_within", None)
    between = [x[:LONGEST] for x in within(path)] if within is not None else []
    held = [*lines, *between, *(_throughout([c for c in found if c.name not in told], texts) if table else ())]
    return Beside(system_said(held, [c.name for c in found]), both_said(held), bend_said(held), starts_said(lines))


def remarks_of(chosen: Format, path: Path) -> list[str]:
    """Return the lines and properties that a file holds beside its readings, none in a format that has no such."""
    beside = getattr(chosen, "remarks", None)
    return list(beside(path)) if beside is not None else []


def _throughout(found: Sequence[Channel], texts: Callable[[str], list[str]]) -> list[str]:
    """Return what columns of text that hold one word for the whole table, and counts of passes, say."""
    lines = []
    for one in found:
        passes = bool(PASSES.intersection(said(one.name).words))
        if one.text or passes:
            held = list(dict.fromkeys(texts(one.name)))
            lines += [f"{'passes' if passes else one.name}: {t}" for t in held if passes or len(held) == 1]
    return lines

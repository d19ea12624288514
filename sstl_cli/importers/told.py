"""What a file of arrays says of a channel beside its name: texts in the same struct, and lists with one for each column of a matrix."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

# of a struct, the field that holds the readings, and those that say what they are (Simulink's signals, ControlDesk's X and Y)
READINGS = ("values", "value", "data")
LABELS = ("label", "name")
UNITS = ("unit", "units")
# in the name of a list with a text for each column of a matrix
_NAMES = ("names", "name", "labels", "label", "channels", "channel", "columns", "header", "headers", "legend", "variables", "signals")
_COLUMN = re.compile(r"(.*)\[(\d+)\]")


def told(channels: Sequence[str], texts: Mapping[str, Sequence[str]]) -> dict[str, tuple[str, str]]:
    """Return label and unit of the channels for which a file states one of them.

    Parameters
    ----------
    channels : sequence of str
        Channels of numbers; columns of a matrix are ``name[1]``, ``name[2]``, ...
    texts : dict
        What the channels of text hold.

    Examples
    --------
    >>> told(["r.Y(1).Data", "m[1]", "m[2]"], {"r.Y(1).Name": ["Fin"], "r.Y(1).Unit": ["N"], "names": ["t", "Fout"]})
    {'r.Y(1).Data': ('Fin', 'N'), 'm[1]': ('t', ''), 'm[2]': ('Fout', '')}
    """
    alone = {n.lower(): str(t[0]).strip() for n, t in texts.items() if len(t) == 1}
    columns = [m for m in map(_COLUMN.fullmatch, channels) if m]
    widths = Counter(m[1] for m in columns)
    names, units = _lists(texts, widths, _NAMES), _lists(texts, widths, UNITS)
    out = {}
    for name in channels:
        head, _, field = name.rpartition(".")
        found = ("", "")
        if column := _COLUMN.fullmatch(name):
            matrix, at = column[1], int(column[2]) - 1
            found = (names[matrix][at] if matrix in names else "", units[matrix][at] if matrix in units else "")
        elif field.lower() in READINGS and head:
            found = (_first(alone, head, LABELS), _first(alone, head, UNITS))
        if any(found):
            out[name] = found
    return out


def _first(alone: Mapping[str, str], head: str, fields: Sequence[str]) -> str:
    return next((text for f in fields if (text := alone.get(f"{head}.{f}".lower(), ""))), "")


def _lists(texts: Mapping[str, Sequence[str]], widths: Mapping[str, int], known: Sequence[str]) -> dict[str, list[str]]:
    """Return the list of texts for the columns of a matrix; where several lists or matrices may be meant, none is."""
    of: dict[str, list[list[str]]] = {}
    for name, held in texts.items():
        wide = [m for m, n in widths.items() if n == len(held)]
        words = re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name.rpartition(".")[2])
        if len(wide) == 1 and words and words[-1].lower() in known:
            of.setdefault(wide[0], []).append([str(t).strip() for t in held])
    return {matrix: lists[0] for matrix, lists in of.items() if len(lists) == 1}

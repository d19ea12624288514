"""Which system a file tells beside its table: in lines above the samples, properties, names of groups and texts that hold for all of it."""

from __future__ import annotations

import re
from collections.abc import Iterable

from sstl_cli.importers.systems import SYSTEM_OF, known_system

# not as part of a name or a path; act is short for actual as well, and must fill its cell
_SSTL = re.compile(r"(?<![\w./\\-])sstl(?![\w./\\-]*[\w/\\-])", re.IGNORECASE)
_ACT = re.compile(r"(?:^|[:=;,\t#])\s*act\s*(?:$|[;,\t(])", re.IGNORECASE)
_EITHER = re.compile(r"\bact\b.*\bsstl\b|\bsstl\b.*\bact\b", re.IGNORECASE)
# system: sstl (double pass), bend 60 deg
_STATED = re.compile(r"\bsystem\b\W*[:=;,\t]\W*([A-Za-z][A-Za-z _-]*)", re.IGNORECASE)


def system_said(remarks: Iterable[str], channels: Iterable[str]) -> str:
    """Return the one system that remarks, or the groups that channels stand in, tell; an empty text where they tell none, or both.

    Examples
    --------
    >>> system_said(["# system: sstl (double pass), bend 60 deg"], ["Fin"]), system_said(["act, later sstl"], []), system_said([], ["act/Fin"])
    ('sstl', '', 'act')
    """
    lines = list(remarks)
    stated = {known_system(m[1].strip()) for line in lines for m in _STATED.finditer(line)} - {""}
    single = [line for line in lines if not _EITHER.search(line)]
    named = {system for system, word in (("act", _ACT), ("sstl", _SSTL)) if any(map(word.search, single))}
    groups = {SYSTEM_OF.get(part.lower(), "") for name in channels for part in re.split(r"[/.]", name)[:-1]} - {""}
    found = stated or named | groups
    return found.pop() if len(found) == 1 else ""

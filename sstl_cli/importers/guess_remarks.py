"""Which system and which bend a file tells beside its table: in lines above the samples, properties, names of groups and texts that hold for all of it."""

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
# bend angle: 45 deg; Biegung = 22,5; config_id: CP-040
_BEND = re.compile(
    r"(?:^|[\W_])(?:bend(?:ing)?|biegung|biegewinkel|krümmung|curvature|courbure|cintrage|flexion|curvatura|doblado|piega|弯曲角?度?|曲げ(?:角度)?)"
    r"(?:[ _](?:angle|radius|deg|mm|config\w*|no|nr|id))*\s*(?:[(\[][^()\[\]]{0,12}[)\]])?\s*[:=;,\t ]\s*\"?([+-]?\d+(?:[.,]\d+)?)"
    r"|(?:^|[\W_])(?:config(?:uration)?(?:[ _]?(?:id|no|nr))?|konfiguration)\s*[:=;,\t]\s*\"?([\w.+-]{1,24})",
    re.IGNORECASE,
)


def bend_said(remarks: Iterable[str]) -> tuple[str, str]:
    """Return the one bend, or the name of a configuration, that remarks tell, and the line that does; two empty texts where none does, or several differ.

    Examples
    --------
    >>> bend_said(["# operator: kk", "# bend angle: 45 deg"]), bend_said(["bend 30, later bend 60"]), bend_said(["Config ID;CP-040"])
    (('45', '# bend angle: 45 deg'), ('', ''), ('CP-040', 'Config ID;CP-040'))
    """
    found = {(m[1] or m[2]): line.strip() for line in remarks for m in _BEND.finditer(line)}
    return found.popitem() if len(found) == 1 else ("", "")


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

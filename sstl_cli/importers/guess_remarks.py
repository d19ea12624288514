"""Which system and which bend a file tells beside its table: in lines above the samples, properties, names of groups and texts that hold for all of it."""

from __future__ import annotations

import re
from collections.abc import Iterable

from sstl_cli.importers.systems import SYSTEM_OF, known_system

# not as part of a name or a path; act is short for actual as well, and must fill its cell
_SSTL = re.compile(r"(?<![\w./\\-])sstl(?![\w./\\-]*[\w/\\-])", re.IGNORECASE)
_ACT = re.compile(r"(?:^|[:=;,\t#])\s*act\s*(?:$|[;,\t(])", re.IGNORECASE)
_EITHER = re.compile(r"\bact\b.*\bsstl\b|\bsstl\b.*\bact\b", re.IGNORECASE)
# system: sstl (double pass), bend 60 deg; Configuration: single pass
_STATED = re.compile(
    r"(?:\b|_)(?:system|config(?:uration)?|konfiguration|configuracion|configurazione)\b\W*[:=;,\t]\W*([A-Za-z][A-Za-z _-]*)", re.IGNORECASE
)
# bend angle: 45 deg; Biegung = 22,5; config_id: CP-040
_BEND = re.compile(
    r"(?:^|[\W_])(?:bend(?:ing)?|biegung|biegewinkel|krümmung|curvature|courbure|cintrage|flexion|curvatura|doblado|piega|弯曲角?度?|曲げ(?:角度)?|sheath[ _]angle)"
    r"(?:[ _](?:angle|radius|deg|mm|config\w*|no|nr|id))*\s*(?:[(\[][^()\[\]]{0,12}[)\]])?\"?\s*[:=;,\t ]\s*\"?([+-]?\d+(?:[.,]\d+)?)"
    r"|(?:^|[\W_])(?:config(?:uration)?(?:[ _]?(?:id|no|nr))?|konfiguration)\s*[:=;,\t]\s*\"?([\w.+-]{1,24})",
    re.IGNORECASE,
)
# as people speak of it: 20 deg bend, sheath bent by 20 deg, act_bend20
_SPOKEN = re.compile(
    r"(?<![\w.,])(\d+(?:[.,]\d+)?)[ _]?(?:°|deg\w*|mm)?[ _]be(?:nd|nt)\b|(?:^|[\W_])(?:bend|bent)(?:\d+\W+)?[ _=:-]*(?:by|of|at|to)?[ _=:-]*(\d+(?:[.,]\d+)?)",
    re.IGNORECASE,
)
_PASS = re.compile(r"(?<![^\W_])(?:single|double)[ _-]?pass(?![^\W_])", re.IGNORECASE)
# of a line in a question
SHOWN = 48


def bend_said(remarks: Iterable[str]) -> tuple[str, str]:
    """Return the bend, or the name of a configuration, that remarks tell, and the line that does; ``...`` and the first two lines where several differ.

    Examples
    --------
    >>> bend_said(["# operator: kk", "# bend angle: 45 deg"]), bend_said(["bendAngle: 30", "Config ID;CP-040"])
    (('45', '# bend angle: 45 deg'), ('...', "bendAngle: 30' and 'Config ID;CP-040"))
    >>> bend_said(["Configuration: single pass", "Bend: 20"]), bend_said(["operator: kk"])
    (('20', 'Bend: 20'), ('', ''))
    >>> bend_said(["# sheath bent by 20 deg"]), bend_said(["20 deg bend, single pass"])
    (('20', '# sheath bent by 20 deg'), ('20', '20 deg bend, single pass'))
    """
    lines, found = list(remarks), dict[str | float, tuple[str, str]]()
    for line in lines:
        # bendAngle
        plain = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", line)
        # a configuration that is a system is no bend
        systems = [m.end(1) for m in _STATED.finditer(plain) if known_system(m[1].strip())]
        for m in _BEND.finditer(plain):
            if not (m[2] and any(m.start(2) < end for end in systems)):
                found.setdefault(alike(m[1] or m[2]), (m[1] or m[2], line.strip()))
    if not found:
        found = {alike(m[1] or m[2]): (m[1] or m[2], line.strip()) for line in lines for m in _SPOKEN.finditer(line)}
    told = list(found.values())
    return ("...", "' and '".join(dict.fromkeys(line[:SHOWN] for _, line in told[:2]))) if len(told) > 1 else (told or [("", "")])[0]


def alike(label: str) -> str | float:
    """Return what two ways to write one label have in common: a number."""
    try:
        return float(label.replace(",", "."))
    except ValueError:
        return label


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
    ways = [{known_system(w) for w in _PASS.findall(line)} for line in lines]
    named |= {system for told in ways if len(told) == 1 for system in told} - {""}
    groups = {SYSTEM_OF.get(part.lower(), "") for name in channels for part in re.split(r"[/.]", name)[:-1]} - {""}
    found = stated or named | groups
    return found.pop() if len(found) == 1 else ""

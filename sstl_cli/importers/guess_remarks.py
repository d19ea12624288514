"""Which system and which bend a file tells beside its table: in lines above the samples, properties, names of groups and texts that hold for all of it."""

from __future__ import annotations

import re
from collections.abc import Iterable

from sstl_cli.importers.guess_words import words
from sstl_cli.importers.systems import SYSTEM_OF, known_system

# not as part of a name or a path; act is short for actual as well, and must fill its cell
_SSTL = re.compile(r"(?<![\w./\\-])sstl(?![\w./\\-]*[\w/\\-])", re.IGNORECASE)
_ACT = re.compile(r"(?:^|[:=;,\t#])\s*act\s*(?:$|[;,\t(])", re.IGNORECASE)
_EITHER = re.compile(r"\bact\b.*\bsstl\b|\bsstl\b.*\bact\b", re.IGNORECASE)
# system: sstl (double pass), bend 60 deg; Configuration: single pass
_STATED = re.compile(
    r"(?:\b|_)(?:system|config(?:uration)?|konfiguration|configuracion|configurazione)\b\W*[:=;,\t]\W*([A-Za-z][A-Za-z _-]*)", re.IGNORECASE
)
# bend angle: 45 deg; Biegung = 22,5; Krümmungsradius: 50; Curvature 1/R = 0.02; Bending: none; config_id: CP-040
_BEND = re.compile(
    r"(?:^|[\W_])(?:bend(?:ing)?|bieg(?:ung|ewinkel|eradius)|krümmung(?:sradius)?|kruemmung(?:sradius)?|curvature|courbure|cintrage|flexion|curvatura|doblado|piega|弯曲角?度?|曲げ(?:角度)?"
    r"|wrap(?:ping)?[ _]angle|umschlingungswinkel|sheath[ _]angle)(?:[ _](?:angle|radius|deg|mm|config\w*|no|nr|id))*\s*(?:1\s*/\s*r\b)?\s*(?:[(\[][^()\[\]]{0,12}[)\]])?"
    r"\"?\s*[:=;,\t ]\s*\"?((?:\d+(?:[.,]\d+)?[ *]*)?(?:pi\b|π)(?:\s*/\s*\d+)?|[+-]?\d+(?:[.,]\d+)?|(?:none|straight)\b)"
    r"|(?:^|[\W_])(?:config(?:uration)?(?:[ _]?(?:id|no|nr))?|konfiguration)\s*[:=;,\t]\s*\"?([\w.+-]{1,24})",
    re.IGNORECASE,
)
_NUMBER = r"\"?([+-]?\d+(?:[.,]\d+)?)"
_LENGTH = r"(?:mm|cm|m|in|inch)"
_ANGLE = r"(?:°|deg\w*|grad\w*|rad)"
# by the letter of a formula, or a word that may be of something else as well: theta = 20 deg, θ: 20°, Angle (deg): 45; with its unit
_LETTERS = re.compile(
    r"(?:^|[#%;,/\t(])[\s\"]*(?:total|sheath|tube)?[ _]*(?:theta|θ|ϑ|phi|φ|ϕ|angle|winkel|angulo|ángulo|angolo)(?:[ _]*(?:tot(?:al)?|sheath|0))?\s*"
    rf"(?:[(\[_ ]\s*{_ANGLE}\s*[)\]]?\"?\s*[:=;,\t]\s*{_NUMBER}|[:=]\s*{_NUMBER}\s*{_ANGLE}(?![a-z])|(?<=[aθϑ])\s*[:=]\s*{_NUMBER}\s*$)",
    re.IGNORECASE,
)
# R = 50 mm, Radius (mm): 50: of the bend, or of a spool
_RADIUS = re.compile(
    r"(?:^|[#%;,/\t(])[\s\"]*(?:sheath|tube)?[ _]*(?:r|radius|rayon|radio|raggio)(?:[ _]*sheath)?\s*"
    rf"(?:[(\[_ ]\s*{_LENGTH}\s*[)\]]?\"?\s*[:=;,\t]\s*{_NUMBER}|[:=]\s*{_NUMBER}\s*{_LENGTH}(?![a-z]))",
    re.IGNORECASE,
)
# an angle without a word for what it is of
_BARE = re.compile(
    r"(?<![\w.,+-])(\d+(?:[.,]\d+)?)[ ]?(?:°(?!\s*(?:[CFKNSEW]\b|/))|deg(?:ree)?s?\b(?!\s*(?:[CFKNSEW]\b|/)))", re.IGNORECASE
)
# as people speak of it: 20 deg bend, sheath bent by 20 deg, act_bend20
_SPOKEN = re.compile(
    r"(?<![\w.,])(\d+(?:[.,]\d+)?)[ _]?(?:°|deg\w*|mm)?[ _]be(?:nd|nt)\b|(?:^|[\W_])(?:bend|bent)(?:\d+\W+)?[ _=:-]*(?:by|of|at|to)?[ _=:-]*(\d+(?:[.,]\d+)?)",
    re.IGNORECASE,
)
_PASS = re.compile(r"(?<![^\W_])(?:single|double|one|two)[ _-]?pass(?![^\W_])", re.IGNORECASE)
# Passes: 2, n_pass = 1, "number of passes",2
_PASSES = re.compile(
    r"(?<![^\W_])(?<!low[-_ ])(?<!high[-_ ])(?<!band[-_ ])pass(?:es)?(?:[ _](?:no|nr|count|number))?\"?\s*[:=;,\t]\s*\"?([12]|[A-Za-z]+)(?:\.0+)?(?![\w.])",
    re.IGNORECASE,
)
_WAY_OF_COUNT = {"1": "act", "2": "sstl"}
# of other parts of a rig, and of a wave
_OF_ELSE = words(
    "motor drive servo spool drum pulley capstan winch roll pitch yaw phase phasen tip gripper temp temperature hz amplitude lat lon latitude longitude "
    "resolution accuracy sensitivity error drift step encoder joint rotation knob offset"
)
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
    >>> bend_said(["theta = 20 deg"]), bend_said(["R = 50 mm"]), bend_said(["Motor angle: 20 deg"])
    (('20', 'theta = 20 deg'), ('50', 'R = 50 mm'), ('', ''))
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
    for form in (_SPOKEN, _LETTERS, _RADIUS):
        if not found:
            found = {alike(v): (v, line.strip()) for line in lines for m in form.finditer(line) if (v := next(filter(None, m.groups())))}
    if not found:
        # of a motor, or of a phase, as a word of the line says
        free = [x for x in lines if not _OF_ELSE.intersection(re.findall(r"[a-z]+", x.lower()))]
        found = {alike(m[1]): (m[1], line.strip()) for line in free for m in _BARE.finditer(line)}
    told = list(found.values())
    return ("...", "' and '".join(dict.fromkeys(line[:SHOWN] for _, line in told[:2]))) if len(told) > 1 else (told or [("", "")])[0]


def is_radius(line: str) -> bool:
    """Return whether a line tells no bend but a radius, which may be that of a spool.

    Examples
    --------
    >>> is_radius("# R = 50 mm"), is_radius("# Bend radius: 50 mm, theta = 20 deg")
    (True, False)
    """
    return (
        bend_said([line])[0] != ""
        and not any(form.search(line) for form in (_BEND, _SPOKEN, _LETTERS))
        and _RADIUS.search(line) is not None
    )


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
    stated = _stated(lines)
    single = [line for line in lines if not _EITHER.search(line)]
    named = {system for system, word in (("act", _ACT), ("sstl", _SSTL)) if any(map(word.search, single))}
    ways = [{known_system(w) for w in _PASS.findall(line)} for line in lines]
    named |= {system for told in ways if len(told) == 1 for system in told} - {""}
    groups = {SYSTEM_OF.get(part.lower(), "") for name in channels for part in re.split(r"[/.]", name)[:-1]} - {""}
    found = stated or named | groups
    return found.pop() if len(found) == 1 else ""


def both_said(remarks: Iterable[str]) -> str:
    """Return what is to be done about remarks that state both systems, as a count of passes does that changes; an empty text where they do not.

    Examples
    --------
    >>> both_said(["passes: 1", "passes: 2"]), both_said(["passes: 1"])
    ('the file says both act and sstl: split it there, or add a column that holds these words', '')
    """
    return (
        "the file says both act and sstl: split it there, or add a column that holds these words" if len(_stated(list(remarks))) > 1 else ""
    )


def _stated(lines: list[str]) -> set[str]:
    """Return the systems that lines state in so many words, or by a count of passes."""
    stated = {known_system(m[1].strip()) for line in lines for m in _STATED.finditer(line)}
    return (stated | {_WAY_OF_COUNT.get(m[1], known_system(m[1])) for line in lines for m in _PASSES.finditer(line)}) - {""}

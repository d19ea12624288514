"""What a channel's name says: quantity, side of the transmission, reference or measured, and unit."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise

from sstl_cli.core.units import is_unit, unit_of
from sstl_cli.importers.guess_words import (
    BRIDGE,
    DIMENSIONS,
    ELSE,
    NOT_MEASURED,
    PLACED,
    PLACED_STEMS,
    QUANTITY,
    QUANTITY_OF,
    REFERENCE,
    SIDE_OF,
    SIGNS,
    STEMS,
    STRANGE,
    UNIT_CELLS,
    UNIT_WORDS,
    as_volts,
    lowered,
    unaccented,
)

# Data Set 1:Force In(N), Latest: Force: which run, and no word of the channel
RUN_IN_FRONT = re.compile(
    r"\s*(?:latest|(?:data[ _]?set|run|trial|test|datensatz|versuch|messung|essai|ensayo|prova|serie|series)[ _]*\d+)\s*:\s*", re.IGNORECASE
)
# Force (N) Run #1, as other programs write it
RUN_BEHIND = re.compile(r".*\brun\s*#?\s*\d+\s*", re.IGNORECASE)
_BRACKETS = re.compile(r"[\[({<]([^\[\](){}<>]{0,40})[\])}>]")
# -Fin, ch2-ch1, Fin x2, Fin*10, Fin 10^3
_COMPUTED = re.compile(
    r"^\s*-(?=\s*[A-Za-z])|\b[a-z]+\d+\s*-\s*[a-z]+\d+\b|\sx\d+\b|[*×]\s*\d+|\b10\s*(?:\^|\*\*)|\b10[⁻⁺⁰¹²³⁴-⁹]", re.IGNORECASE
)
# Fin_x2, Fin (x2), Fin_2x; 2xFin, 10*Fin; Fin/10; Fin_times2; F_in per strand: what was recorded may be a multiple of the force
_MULTIPLE = re.compile(
    r"(?<![^\W_])[x×*]\s*(?!1(?![\d.,]))\d+(?:[.,]\d+)?(?![^\W_])|(?<![^\W_])\d+(?:[.,]\d+)?\s*(?:[x×](?![^\W\d_\s]*\d)|[*·])(?=\s*(?:[A-Z]|$|[_)\]]))"
    r"|(?<![^\W_])\d+(?:[.,]\d+)?[x×](?![^\W_])|^[^/]*[^\W\d_]\s*[/÷]\s*(?:10+|[2-9])(?![^\W_])|(?<![^\W_])1/\d+(?=[\s*]*[A-Z])|(?<![^\W_])times[ _]?\d+"
    r"|(?<![^\W_])(?:doubled|halved|scaled|twice|tenfold|twofold|verdoppelt|halbiert|skaliert|half(?![ _-]?bridge)|total|gesamt"
    r"|(?:per|pro|par|por)[ _](?:strand|tendon|cable|wire|rope|leg|line|strang|seil|litze|brin))(?![^\W_])",
    re.IGNORECASE,
)
# dFin, ΔFin: what a force changes by
_CHANGE = re.compile(r"(?:^|[\s_./])(?:d(?=[A-Z])|[ΔδΔ∂∆])")
# S/N 712345 on the plate of a sensor: its n counts nothing
_SERIAL = re.compile(r"\b(?:s/n|sn|serial(?:\s*(?:no|nr|number))?)\b[.:#]*\s*[\w-]*\d[\w-]*", re.IGNORECASE)
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|#|%")
_NUMBER = r"[x*×·/]?\s*\d+(?:[.,]\d+)?(?:[eE][-+]?\d+|\s*(?:\^|\*\*)\s*[-−+]?\d+|[⁻⁺]?[⁰¹²³⁴-⁹]+)?\s*[x*×·]?"
# "0.1 N", "x10 N", "N*100", "10^-3 N", "N/10": a unit of the file's own
_SCALED = re.compile(rf"{_NUMBER}\s*([^\W\d_]+)|([^\W\d_]+)\s*{_NUMBER}")
_SHORT = re.compile(r"(?:f|t|ft|force|tension|load|tau)(in|out|prox|dist|tip|mot|ref|cmd|des|soll|ein|aus)")
# at the end of a name, in letters that are no word of it
_UNIT_TAIL = re.compile(r"(?<=[^\W_])[_ \-.](N|mN|cN|dN|daN|kN|uN|lbf|kgf|gf|ozf|mV)$")
_ORDER = tuple(QUANTITY)
# hours and minutes are no unit of a column of ticks: q_min is the least q
_STEPS = ("s", "ms", "us", "ns", "MS", "US", "NS")
# they stand for no number of order, as the second does
_TICKS = ("millis", "micros", "nanos", "msec", "msecs", "usec", "usecs", "nsec", "nsecs")
_SAFE_TAIL = {
    "force": ("N", "mN", "cN", "dN", "daN", "kN", "uN", "kgf", "gf", "lbf", "ozf", "kg", "g", "lb", "lbs", "V", "mV", "n", "kn", "mn"),
    "time": ("s", "ms", "us", "ns", "S", "MS", "US", "NS", "min", "Min", "h"),
    "position": ("mm", "cm", "m", "um", "deg", "rad"),
    "angle": ("deg", "rad", "rev"),
    "pressure": ("bar", "psi", "kPa", "MPa", "Pa", "mbar"),
}


@dataclass(frozen=True)
class Said:
    """What a name says; empty where it says nothing.

    ``unit`` is a known unit, ``strange`` the text of one that is not, ``doubt`` a question that the file raises about the channel;
    ``stamped`` says that it holds times written as text.
    """

    name: str
    words: tuple[str, ...]
    quantity: str = ""
    side: str = ""
    reference: bool = False
    unit: str = ""
    strange: str = ""
    doubt: str = ""
    stamped: bool = False

    @property
    def unmeasured(self) -> str:
        """The word that says that the channel was not measured (empty if none does)."""
        # Model Root/Plant/T_in: a block diagram's name is no word of the channel's
        root = next(
            (i + 2 for i, pair in enumerate(pairwise(self.words)) if pair == ("model", "root")), int(self.name.lower().startswith("model/"))
        )
        own = self.words[root:]
        # a name of its unit alone has no word; log10 is cut into a word and a number
        found = next((w for w, after in zip(own, (*own[1:], ""), strict=False) if w in NOT_MEASURED or w + after in NOT_MEASURED), "")
        # T_in_d and T_in*, as control writes what is desired
        desired = "*" if self.name.split("(")[0].split("[")[0].rstrip().endswith("*") else "d" if own[-1:] == ("d",) and self.side else ""
        # F_in_dN: the d of a unit
        plain = _UNIT_TAIL.sub("", _BRACKETS.sub("", self.name))
        computed = _COMPUTED.search(plain) or (_CHANGE.search(plain) if self.quantity == "force" else None)
        return found or desired or (computed[0].strip(" _./") if computed else "")

    @property
    def multiple(self) -> str:
        """What says that the channel may be a multiple or a part of the force (``x2``, ``half``), an empty text where nothing does."""
        plain = _BRACKETS.sub(lambda m: " " if any(_unit(m[1].strip())) else m[0], self.name)
        found = _MULTIPLE.search(_UNIT_TAIL.sub("", plain)) if self.side or self.quantity == "force" else None
        return found[0].strip(" _*") if found else ""

    @property
    def placed(self) -> bool:
        """Whether a word says that this is a position: its unit alone may be that of any length."""
        if DIMENSIONS.intersection(self.words):
            return False
        return any(w in PLACED or (len(w) > 5 and any(stem in w for stem in PLACED_STEMS)) for w in self.words)

    @property
    def dimension(self) -> str:
        """Dimension of the unit (empty if there is none)."""
        return unit_of(self.unit)[0] if self.unit else ""

    @property
    def tension(self) -> bool:
        """Whether this is a measured force: by its unit, or by its name and no unit of something else."""
        # a bridge's mV/V is that of a load cell; other ratios are none of a force
        ratio = "/" in self.strange and _bare(self.strange) not in BRIDGE
        if self.reference or ratio or _bare(self.strange) in ELSE or self.quantity in ("current", "other", "time", "index"):
            return False
        if self.dimension == "force":
            return True
        return self.quantity == "force" and self.dimension in ("", "voltage", "count")


def said(name: str, stated: str = "") -> Said:
    """Return what a channel's name says.

    Parameters
    ----------
    stated : str
        Unit that the file states apart from the name (a row of units, a property of the channel).

    Examples
    --------
    >>> s = said("Kraft Ausgang [N]")
    >>> (s.quantity, s.side, s.unit)
    ('force', 'out', 'N')
    """
    unit, strange = _unit(stated) if stated else ("", "")
    # T_in_N.Data, /F_out_N/data: the field that holds the readings says nothing of them
    text = re.sub(r"(?<=\w)[./](?:data|values?)$", "", as_volts(name), flags=re.IGNORECASE)
    text = RUN_IN_FRONT.sub("", text, count=1) if RUN_IN_FRONT.match(text) else text
    # the ports of a block diagram are no side of a transmission
    plain = re.sub(r"[/.](?:Out|In)\d*(?=\s*(?:[\[(][^\[\]()]*[\])])?$)", "", text)
    plain = _SERIAL.sub(" ", plain)
    for found in _BRACKETS.finditer(text):
        inside = found[1].strip()
        known, odd = _unit(inside)
        if inside in ("C", "K", "F") and re.match("t(?![a-z])", name, re.IGNORECASE):
            # T_motor (C): a temperature
            known, odd = "", f"deg{inside}"
        if (known or odd) and not (unit or strange):
            unit, strange = known, odd
        if known or odd:
            plain = plain.replace(found[0], " ")
    spoken = re.fullmatch(r"(.*\S)\s+in\s+(\S+)", plain.strip())
    if spoken and not (unit or strange) and any(_unit(spoken[2])):
        # "Ausgangskraft in N": this "in" belongs to the unit; "Force in N" may be either, and says no side
        plain, (unit, strange) = spoken[1], _unit(spoken[2])
    ending = _UNIT_TAIL.search(plain)
    if ending and not (unit or strange):
        # the letters of a unit are no words: "n" would count samples
        plain, unit = plain[: ending.start()], ending[1]
    words = _words(plain)
    quantity, side, reference = _meaning(words)
    if quantity == "other" and unit and unit_of(unit)[0] == "force" and _strained(words):
        quantity = "force"
    if quantity == "force" and unit and unit_of(unit)[0] in ("length", "angle") and any(QUANTITY_OF.get(w) == "position" for w in words):
        # fActPos [mm]: the f of a programme's float
        quantity = "position"
    if not unit and not strange:
        unit, strange = _tail(plain, words, quantity)
        if unit in ("counts", "V", "mV") or not quantity:
            quantity = quantity or {"time": "time", "force": "force"}.get(unit_of(unit)[0] if unit else "", "")
    if quantity == "force" and unit and unit_of(unit)[0] == "time":
        # t_motor (ms)
        quantity = "time"
    if not quantity and unit:
        quantity = {"force": "force", "time": "time", "length": "position", "angle": "angle"}.get(unit_of(unit)[0], "")
    return Said(name, words, quantity, side, reference, unit, strange)


def time_unit(name: str) -> str:
    """Return the unit of time that a name ends in behind another word, an empty text where it ends in none.

    Examples
    --------
    >>> [time_unit(n) for n in ("tick2_ms", "t_plc_s", "F_in", "ms")]
    ['ms', 's', '', '']
    """
    parts = re.split(r"[\s_\-.]+", _plain(name).strip())
    return parts[-1].lower() if len(parts) > 1 and parts[-1] in _STEPS else ""


def contradicted(one: Said, own: Said) -> str:
    """Return the unit that a name states against the one that its file states apart from it, an empty text where they agree or one states none."""
    if not one.unit or own.dimension == "count" or (own.unit == "in" and one.dimension != "length"):
        return ""
    differs = unit_of(own.unit) != unit_of(one.unit) if own.unit else bool(own.strange)
    return (own.unit or own.strange) if differs else ""


def _strained(words: tuple[str, ...]) -> bool:
    """Whether a load cell is called by its strain, and by nothing else that is no force."""
    others = {w for w in words if QUANTITY_OF.get(w) == "other"}
    return others <= {"strain", "dehnung"} and any(QUANTITY_OF.get(w) == "force" for w in words)


def _unit(text: str) -> tuple[str, str]:
    """Return a known unit, or the text of a strange one, or neither."""
    text = as_volts(text).strip().strip(".")
    text = re.sub(r"^(in|en)\s+", "", text)
    if is_unit(text) and text != "in":
        return text, ""
    if text in ("in", "inch", "inches"):
        return "in", ""
    plain = _plain(text).lower()
    if plain in UNIT_CELLS:
        return UNIT_CELLS[plain], ""
    if _bare(text) in STRANGE or "%" in plain or re.fullmatch(r"[a-z]{1,3}/[a-z]{1,4}2?", plain):
        return "", text
    scaled = _SCALED.fullmatch(text)
    if scaled and is_unit(scaled[1] or scaled[2]):
        return "", text
    return "", ""


def _bare(unit: str) -> str:
    """Return a unit without case, accents and signs of multiplication (``N·m``)."""
    return re.sub(r"[.*· ]", "", _plain(unit).lower())


def _words(text: str) -> tuple[str, ...]:
    out: list[str] = []
    text = lowered(text)
    for sign, word in SIGNS.items():
        text = text.replace(sign, f" {word} ")
    for word in _WORDS.findall(_plain(text)):
        low = word.lower()
        short = _SHORT.fullmatch(low)
        if short:
            out += ["force", short[1].replace("mot", "motor").replace("soll", "ref")]
        else:
            out.append(low)
    return tuple(out)


def _plain(text: str) -> str:
    text = text.replace("µ", "u").replace("μ", "u").replace("°", "deg").replace("ß", "ss")
    return unaccented(text)


def _meaning(words: tuple[str, ...]) -> tuple[str, str, bool]:
    quantities: list[str] = []
    sides: list[str] = []
    reference = any(w in REFERENCE for w in words)
    if words[:2] == ("x", "value") and all(w.isdigit() for w in words[2:]):
        # the time axis of LabVIEW's text files, of each channel where there are several
        return "time", "", False
    if ("header", "stamp") in pairwise(words) or ("header", "seq") in pairwise(words):
        # of a ROS message, wherever it was sent from
        sides = [SIDE_OF[w] for w in words if w in SIDE_OF]
        return ("time" if "stamp" in words else "index"), (sides[0] if len(set(sides)) == 1 else ""), False
    # of a ROS message of that name the field says what it holds
    message = {i for i, pair in enumerate(pairwise(words)) if pair in (("joint", "state"), ("joint", "states"))}
    words = tuple(w for i, w in enumerate(words) if not {i, i - 1} & message)
    for i, word in enumerate(words):
        kind = QUANTITY_OF.get(word, "")
        side = SIDE_OF.get(word, "") or ("out" if words[i : i + 2] == ("load", "side") else "")
        if word == "f" or (word == "t" and len(words) > 1 and (i == 0 or any(w in SIDE_OF for w in words[i + 1 : i + 2]))):
            # F1, F_in, T_out, Model/Plant/T_in: a force; t alone is time; T1 may be anything
            kind = "force" if word == "f" or any(w in SIDE_OF for w in words[i + 1 :]) else ""
            if word == "t" and words[1:] in (("s",), ("ms",), ("us",), ("ns",)):
                kind = "time"
        if side:
            sides.append(side)
        elif kind:
            quantities.append(kind)
        elif len(word) > 5:
            for stem, (what, value) in STEMS.items():
                if stem in word:
                    if what == "quantity":
                        quantities.append(value)
                    elif what == "side":
                        sides.append(value)
                    else:
                        reference = True
    quantity = min(quantities, key=_ORDER.index, default="")
    # a load cell at the output is sided once; words of both sides say nothing
    side = sides[0] if len(set(sides)) == 1 else ""
    return quantity, side, reference


def _tail(plain: str, words: tuple[str, ...], quantity: str) -> tuple[str, str]:
    """Return a unit written without brackets, or a strange one, where it fits what is measured."""
    if any(w in ("adc", "raw", "counts", "lsb") for w in words):
        return "counts", ""
    last = re.sub(r"[^\w%/]", "", re.split(r"[\s_\-.,;:/]+", _plain(plain).strip(" _-./,;:"))[-1])
    if "?" in plain:
        # "Fin [N?]": who wrote it did not know
        return "", ""
    if last.lower() in UNIT_WORDS:
        return UNIT_WORDS[last.lower()], ""
    if quantity == "time" and (ticks := [UNIT_WORDS[w] for w in words if w in _TICKS]):
        # millis_A
        return ticks[0], ""
    if last.lower() in ("percent", "pct", "prozent") or last.endswith("%"):
        return "", last
    if len(words) > 1 and last in _SAFE_TAIL.get(quantity, ()):
        return {"n": "N", "kn": "kN", "mn": "mN", "S": "s", "MS": "ms", "US": "us", "NS": "ns", "Min": "min"}.get(last, last), ""
    if len(words) > 1 and not quantity and last in ("N", "mN", "kN", "lbf", "kgf"):
        return last, ""
    return "", ""

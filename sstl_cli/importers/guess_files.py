"""What file names say about recordings: a pattern whose groups are labels, and which side a file holds."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import takewhile

from sstl_cli.importers.guess_angles import BEND, DECIMAL, LETTERED, TURNS, angle_behind, angle_doubt, unit_of_other
from sstl_cli.importers.guess_bends import (
    BEND_DIGITS,
    DECIMALS,
    DENIES,
    DENIES_BEHIND,
    MOTIONS,
    ROUND_DEG,
    maybe_bends,
    perhaps_bends,
    straight_place,
)
from sstl_cli.importers.guess_parts import LETTERS, TRIAL, Columns, at, before, next_word, next_words
from sstl_cli.importers.guess_system import names_systems, no_system, way_of
from sstl_cli.importers.guess_words import LEAD, SIDE_OF, words
from sstl_cli.importers.mapping import LABELS
from sstl_cli.importers.pattern import search
from sstl_cli.importers.systems import SYSTEM_OF, known_system

_PARTS = re.compile(rf"\d+(?:\.\d+)?|[{LETTERS}]+|[^{LETTERS}0-9]+")
# sstlTin, actRun
_WRITTEN_TOGETHER = re.compile(r"\d+(?:\.\d+)?|[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[^A-Za-z0-9]+")
_LOCATIONS = {"NP", "CP", "ND"}
_LENGTHS = words("inch inches zoll cm")


@dataclass(frozen=True)
class Named:
    """A ``file_name`` pattern (empty: none), the labels it gives, a question, the reason, and the system that other words of all names say."""

    pattern: str = ""
    labels: tuple[str, ...] = ()
    question: str = ""
    reason: str = ""
    constants: tuple[tuple[str, str], ...] = ()
    way: str = ""


def name_pattern(stems: list[str], takes: bool = False) -> Named:
    r"""Return the pattern that the names of recordings share.

    Parameters
    ----------
    stems : list of str
        File names without extension.
    takes : bool
        Whether parts that vary and have no meaning count takes, which is no question.

    Examples
    --------
    >>> name_pattern(["bend_030_run1", "bend_060_run1"]).pattern
    '^bend_(?P<config_id>\\d+)_'
    """
    cut = _cut(stems)
    shapes = {tuple(_kind(p) for p in parts) for parts in cut}
    if len(shapes) != 1:
        return Named(reason="the file names are not alike: labels need a manifest (--manifest)")
    columns = list(zip(*cut, strict=True))
    labels, unknown, asked = _labelled(columns, takes)
    question = "; ".join(dict.fromkeys(filter(None, asked)))
    if not labels:
        return Named(reason="" if len(stems) == 1 else "the file names give no label", way=way_of(columns))
    names = dict(labels)
    constants: tuple[tuple[str, str], ...] = ()
    if {"location", "config_id"} <= set(labels.values()):
        # bend 40 at one place is not bend 40 at another
        names = {i: "bend" if n == "config_id" else n for i, n in labels.items()}
        constants = (("config_id", "{location}-{bend}"),)
    elif {"location", "lead_mm"} <= set(labels.values()):
        # where the tube is bent, and how far the screw bends it
        constants = (("config_id", "{location}-{lead_mm}"),)
    body = []
    for i, values in enumerate(columns[: max([*labels, *unknown]) + 2]):
        kind = r"\d+" if not any("." in v for v in values) else r"\d+(?:\.\d+)?"
        shape = kind if values[0][0].isdigit() else _shape(i, columns) if values[0][0].isalpha() else ""
        if i in labels:
            body.append(f"(?P<{names[i]}>{shape})")
        else:
            body.append(shape if len(set(values)) > 1 and shape else re.escape(values[0]))
    shown = ", ".join([f"{labels[i]} from '{columns[i][0]}'" for i in labels] + [f"{k} = {v}" for k, v in constants])
    return Named("^" + "".join(body), tuple(labels.values()), question, f"file names give {shown}", constants, way_of(columns))


def _cut(stems: list[str]) -> Columns:
    """Return the parts of each name; words that are written together are cut where that alone shows a system (``sstlRun1``)."""
    plain = [tuple(_PARTS.findall(s)) for s in stems]
    finer = [tuple(_WRITTEN_TOGETHER.findall(s)) for s in stems]
    shows = [any(p.lower() in SYSTEM_OF for parts in cut for p in parts) for cut in (plain, finer)]
    return finer if shows == [False, True] and len({len(parts) for parts in finer}) == 1 else plain


def _shape(i: int, columns: Columns) -> str:
    """Return a pattern for the words at a place; beside another word it keeps to the letters that tell them apart."""
    if not all(map(str.isascii, columns[i])):
        return r"[^\x00-@\[-`{-\x7f]+"
    together = any(at(k, columns)[:1].isalpha() for k in (i - 1, i + 1))
    shapes = ("[a-z]+", "[A-Z][a-z]+") if together else ()
    return next((shape for shape in shapes if all(re.fullmatch(shape, v) for v in columns[i])), "[A-Za-z]+")


def label_words(names: list[str]) -> set[str]:
    """Return the labels that a word in front of a number, or for a system, tells in all of some names."""
    cut = _cut(names)
    if len({tuple(_kind(p) for p in parts) for parts in cut}) != 1:
        return set()
    columns = list(zip(*cut, strict=True))
    return {label for i, values in enumerate(columns) if (label := _label(i, values, columns))}


def shared_labels(stems: list[str]) -> Named:
    """Return the labels that the names of files with a channel each share, as constants; what differs names the channels.

    Examples
    --------
    >>> shared_labels(["bend60_sstl_Tin", "bend60_sstl_Tout"]).constants
    (('config_id', '60'), ('system', 'sstl'))
    """
    cut = [_WRITTEN_TOGETHER.findall(s) for s in stems]
    front = _common(cut)
    back = _common([parts[len(front) :][::-1] for parts in cut])[::-1]
    shared = "".join([*front, *back])
    named = name_pattern([shared]) if shared else Named()
    [found] = search(named.pattern, [shared])
    labels = (found or {}) | {k: v.format(**(found or {})) for k, v in named.constants}
    return replace(named, pattern="", constants=tuple((k, v) for k, v in labels.items() if k in LABELS))


def _common(parts: list[list[str]]) -> list[str]:
    """Return what names share at their beginning."""
    return [c[0] for c in takewhile(lambda c: len(set(c)) == 1, zip(*parts, strict=False))]


def _labelled(columns: Columns, takes: bool) -> tuple[dict[int, str], list[int], list[str]]:
    """Return the label of each part that has one, the parts that vary without one, and the questions that are left."""
    labels: dict[int, str] = {}
    unknown: list[int] = []
    asked: list[str] = []
    for i, values in enumerate(columns):
        label = _label(i, values, columns)
        if label == "system" and no_system(i, columns):
            continue
        if label == "config_id" and before(i, columns) == "r" and _counts(i, columns) and _bend_elsewhere(i, columns):
            # act_bend45_r1: the bend has a word of its own, and r counts repeats
            continue
        unsure = label == "config_id" and angle_doubt(i, columns) != "" and _sure_elsewhere(i, columns)
        if label and label not in labels.values() and not unsure:
            labels[i] = label
            asked.append(_doubt(i, label, columns))
        elif label:
            asked.append(f"{values[0]} may be the {label} too: which is it?")
        elif label is None and len(set(values)) > 1 and not takes:
            unknown.append(i)
    radius = next((i for i, label in labels.items() if label == "config_id" and before(i, columns) == "r"), None)
    if radius is not None and len(unknown) == 1 and _counts(radius, columns) and not _counts(unknown[0], columns):
        # 30_r1, 30_r2, 60_r1: what counts beside a number of its own are repeats
        asked.remove(_doubt(radius, labels.pop(radius), columns))
    given = set(labels.values())
    fixed = maybe_bends(columns)
    bare = "config_id" not in given and not {"location", "lead_mm"} <= given
    if bare and fixed and len(unknown) == 1 and _repeats(unknown[0], columns):
        labels[fixed[0]] = "config_id"
        asked.append(f"does {_named_by(fixed, columns)} tell the bending configuration, and does the number that varies count runs?")
    elif bare and unknown:
        labels[unknown[0]] = "config_id"
        asked.append("does this part of the name tell the bending configuration?")
    elif len(unknown) == 1 and columns[unknown[0]][0].isdigit():
        asked.append("the number that varies gets no label: if it only counts runs, deleting this mark is enough")
    elif unknown:
        asked.append("the name has parts that vary and got no label")
    elif given & {"system", "location"} and not given & {"config_id", "lead_mm"} and fixed:
        labels[fixed[0]] = "config_id"
        asked.append(f"does {_named_by(fixed, columns)} tell the bending configuration? If not, take config_id out")
    elif not given & {"system", "location", "config_id", "lead_mm"} and (loose := perhaps_bends(columns)):
        labels[loose[0]] = "config_id"
        asked.append(f"does {_named_by(loose, columns)} tell the bending configuration? If not, take config_id out")
    elif "system" in given and not given & {"config_id", "lead_mm"} and (shape := straight_place(columns)) is not None:
        labels[shape] = "config_id"
        asked.append(f"is '{columns[shape][0]}' the bending configuration? If not, take config_id out")
    return labels, unknown, asked


def _bend_elsewhere(i: int, columns: Columns) -> bool:
    """Return whether another number has a word for a bend that is no r."""
    return any(k != i and _label(k, values, columns) == "config_id" and before(k, columns) != "r" for k, values in enumerate(columns))


def _sure_elsewhere(i: int, columns: Columns) -> bool:
    """Return whether another number is a bend beyond doubt: pi4 or 20 °C in front of it is not the label."""
    return any(k != i and _label(k, v, columns) == "config_id" and not _doubt(k, "config_id", columns) for k, v in enumerate(columns))


def _named_by(places: list[int], columns: Columns) -> str:
    front = {i: before(i, columns) for i in places}
    return " or ".join(
        f"{columns[i][0]} behind '{front[i]}'" if front[i] else f"{columns[i][0]} in front of '{next_words(i, columns)[0]}'" for i in places
    )


def _repeats(i: int, columns: Columns) -> bool:
    """Return whether a part counts from 0 or 1 on without a gap, and no letter touches it."""
    return _counts(i, columns) and not (at(i - 1, columns)[-1:].isalpha() or at(i + 1, columns)[:1].isalpha())


def _counts(i: int, columns: Columns) -> bool:
    """Return whether a part counts from 0 or 1 on without a gap."""
    values = {int(v) for v in columns[i] if v.isdigit()}
    return bool(values) and min(values) in (0, 1) and values == set(range(min(values), max(values) + 1))


def side_of(stem: str) -> str:
    """Return ``in`` or ``out`` if a file's name says which side it holds, else an empty text."""
    sides = {SIDE_OF[w.lower()] for w in _PARTS.findall(stem) if w.lower() in SIDE_OF}
    return sides.pop() if len(sides) == 1 else ""


def side_words(stems: list[str]) -> list[str]:
    """Return the words of the names that tell the side, as they are written."""
    return sorted({w for s in stems for w in _PARTS.findall(s) if w.lower() in SIDE_OF})


def taken(stem: str, sides: list[str]) -> tuple[str, bool]:
    """Return the part of a name that both files of a pair share, and whether the word for the side stands in front."""
    words = "|".join(sides)
    front = re.match(rf"(?:{words})(?![A-Za-z])[-_ ]*", stem)
    return (stem[front.end() :], True) if front else (re.split(rf"[-_ ]*(?:{words})(?![A-Za-z])", stem)[0], False)


def _kind(part: str) -> str:
    return "number" if part[0].isdigit() else "word" if part[0].isalpha() else part


def _label(i: int, values: tuple[str, ...], columns: Columns) -> str | None:
    """Return the label that a part of the names gives, an empty text for none, None if it is not known."""
    front = before(i, columns)
    after = at(i + 1, columns)
    if not values[0][0].isalnum():
        return ""
    if values[0][0].isalpha():
        if set(values) <= _LOCATIONS:
            return "location"
        if names_systems(set(map(str.lower, values))):
            return "system"
        if {v.lower() for v in values} <= MOTIONS:
            return "trajectory"
        return "" if len(set(values)) == 1 else None
    if front in LEAD:
        return "lead_mm"
    if front in BEND and not unit_of_other(i, columns):
        return "config_id"
    if after == "mm":
        return "lead_mm"
    if angle_behind(i, columns) or front in LETTERED or front.upper() in _LOCATIONS:
        return "config_id"
    # dates and times of day, and numbers that count recordings
    if front in TRIAL or all(len(v) in (6, 8, 14) for v in values):
        return ""
    return None if len(set(values)) > 1 else ""


def _denial(i: int, columns: Columns) -> str:
    """Return the word beside a label of letters that says that it does not hold (``no_sstl``, ``sstl_off``) in one of the names, '' where none does."""
    if not columns[i][0][0].isalpha():
        return ""
    for place, known in ((next_word(i, -1, columns), DENIES), (next_word(i, 1, columns), DENIES_BEHIND)):
        if place is not None and (found := sorted(known & {v.lower() for v in columns[place]})):
            return found[0]
    return ""


def _doubt(i: int, label: str, columns: Columns) -> str:
    """Return the question that a labelled part of the names leaves, an empty text where it is sure."""
    part, direct, front = columns[i][0], at(i - 1, columns), before(i, columns)
    if denial := _denial(i, columns):
        return f"'{denial}' stands beside '{part}': does it hold here?"
    if label == "lead_mm" and front not in LEAD:
        return f"is {part} mm the lead of a screw, and not a diameter or a length?"
    if label not in ("config_id", "lead_mm"):
        return _system_doubt(columns[i]) if label == "system" else ""
    begin = _may_begin(i, columns) if label == "config_id" else ""
    more = _goes_on(i, columns, label)
    if more or begin:
        return f"is {begin + direct if begin else ''}{part}{more} one number?"
    separators = {p for p in (at(k, columns) for k in range(len(columns)) if k != i - 1) if p and not p[0].isalnum()}
    # CP-040 and act-45deg are hyphens; bend-45 may be bent the other way
    hyphen = direct == "-" and (separators == {"-"} or (at(i - 2, columns)[:1].isalpha() and front not in BEND | LEAD | LETTERED))
    if direct.endswith("-") and not hyphen:
        return f"is the - before {part} its sign, or does it separate?"
    if label == "lead_mm":
        unit = _unit_behind(i, columns)
        return f"is {part}{unit} in mm?" if unit else ""
    if ask := angle_doubt(i, columns):
        return ask
    if front == "r":
        return "" if at(i + 1, columns) == "mm" else f"is r{part} the bend by its radius, or a repeat?"
    if front.upper() in _LOCATIONS and not _plainly_bend(i, columns):
        return f"does {part} beside {front.upper()} tell the bending configuration, or does it count runs or tell something else?"
    # 30deg_s1 is the first subject or sample
    if (
        at(i + 1, columns) in BEND
        and next_words(i + 1, columns)[:1] == ["s"]
        and not re.search(r"s\d", "".join(c[0] for c in columns[i + 1 : i + 5]).lower())
    ):
        return f"is {part} {at(i + 1, columns)} the bend, or a speed per s?"
    known = BEND | set(SYSTEM_OF) | TRIAL | MOTIONS | {p.lower() for p in _LOCATIONS}
    if front in TURNS or (direct[:1].isalpha() and direct not in known):
        return f"is {part} the bend, or the {front} of something else?"
    return ""


def _system_doubt(values: tuple[str, ...]) -> str:
    """Return the question that words for the tendon's way leave, which a name may say of something else."""
    ways = sorted({v.lower() for v in values} - set(SYSTEM_OF))
    said = " and ".join(f"'{w}' as {known_system(w)}" for w in ways)
    return f"is {said} the system (act: single pass, sstl: double pass)?" if ways else ""


def _plainly_bend(i: int, columns: Columns) -> bool:
    """Return whether a number beside a location tells its bend: a word says so, or runs are counted elsewhere in the name and no letter touches it."""
    counted = any(columns[k][0].isdigit() and before(k, columns) in TRIAL for k in range(len(columns)) if k != i)
    return at(i + 1, columns) in BEND or (counted and not at(i + 1, columns)[:1].isalpha())


def _may_begin(i: int, columns: Columns) -> str:
    """Return the number in front of a bend over a separator, where the bend may be its decimals (``22_5deg``), an empty text where none is."""
    number, word = at(i - 2, columns), before(i - 2, columns)
    if at(i - 1, columns) not in ("_", "-", " ") or not number.isdigit() or number[0] == "0" or len(number) > BEND_DIGITS or word in TRIAL:
        return ""
    # 1_45deg and 12_60deg count; 67_25 is a bend of four digits
    decimals = all(len(v) == 1 for v in columns[i]) or ({*columns[i]} <= {"25", "50", "75"} and len(number) > 1)
    return number if decimals else ""


def _goes_on(i: int, columns: Columns, label: str) -> str:
    """Return what may be the decimals of a number behind it (3p5, 3,5, and of a lead 2-5 and 2_5), an empty text where nothing may."""
    mark, digits, behind = (at(i + k, columns) for k in (1, 2, 3))
    if not digits[:1].isdigit():
        return ""
    # bend22_5: no bend is 22 and its fifth repeat at once, where bend30_5 may be
    odd = {v for v in columns[i] if v.isdigit() and int(v) % ROUND_DEG}
    if label == "config_id" and mark in ("_", "-", " ") and odd and {*columns[i + 2]} <= DECIMALS:
        return mark + digits
    # NP_lead10_20240502 and lead10_30deg go on with another number
    short = len(digits) < 3 and (not behind[:1].isalpha() or behind == "mm")
    return mark + digits if mark in DECIMAL or (mark in ("-", "_") and label == "lead_mm" and short) else ""


def _unit_behind(i: int, columns: Columns) -> str:
    """Return the letters right behind a lead that are neither mm nor a word of the name's own, and inch or cm behind a separator, else an empty text."""
    direct = {v.lower() for v in columns[i + 1]} if i + 1 < len(columns) and columns[i + 1][0][0].isalpha() else set()
    own = set(SYSTEM_OF) | TRIAL | MOTIONS | {p.lower() for p in _LOCATIONS} | {"mm"}
    odd = direct - own or set(next_words(i, columns)[:1]) & _LENGTHS
    return min(odd, default="")

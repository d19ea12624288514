"""Which system a file's name tells, and where other words of it speak against that."""

from __future__ import annotations

from sstl_cli.importers.guess_parts import TRIAL, Columns, at, next_word
from sstl_cli.importers.guess_words import QUANTITY_OF, REFERENCE, words
from sstl_cli.importers.systems import SYSTEM_OF, WAY_OF, known_system

# beside these act is what was measured
_ACTUAL = REFERENCE | words("actual measured meas ist vs")
# a tendon that comes back, and one that does not: the beginnings of words, which may go on as in doublepass
_WAYS = {
    "sstl": ("double", "doppel", "doppi", "doble", "loop", "schleife", "boucle", "roundtrip", "twoway", "return", "uturn"),
    "act": ("single", "einfach", "einzel", "simpl", "singol", "sencill", "oneway"),
}
# how many a tendon makes, in front of these: two_pass, 1way
_PASSES = ("pass", "way", "trip")
_TIMES = {"1": "act", "one": "act", "2": "sstl", "two": "sstl", "round": "sstl"}


def names_systems(found: set[str]) -> bool:
    """Return whether words of file names tell the system: a long one may be what the test is about, unless the other system's stands there as well."""
    if found <= {*SYSTEM_OF, *WAY_OF} and len(set(map(known_system, found))) > 1:
        return True
    return found <= set(SYSTEM_OF) and (found <= set(SYSTEM_OF.values()) or len(set(map(known_system, found))) > 1)


def no_system(i: int, columns: Columns) -> bool:
    """Return whether act and sstl in a name need not be its system: both stand there, or words for the other, or act beside what is desired or measured."""
    others = {part.lower() for k, values in enumerate(columns) if k != i for part in values}
    if others & set(SYSTEM_OF) or _other_system(i, columns):
        return True
    # ActForce, written together, is the actual force
    return {part.lower() for part in columns[i]} == {"act"} and bool(others & _ACTUAL - TRIAL or at(i + 1, columns) in QUANTITY_OF)


def way_of(columns: Columns) -> str:
    """Return the system that parts of all names say in other words (``loop_75deg``), an empty text where they say none, or both."""
    told = {_way(k, columns) for k in range(len(columns)) if len(set(columns[k])) == 1} - {""}
    return told.pop() if len(told) == 1 else ""


def _other_system(i: int, columns: Columns) -> bool:
    """Return whether a system that is the same in all names stands beside words for the other one, or is numbered as an actuator is."""
    found = {known_system(part) for part in columns[i]}
    if len(found) != 1:
        # names that differ in it tell it by that
        return False
    told = found.pop()
    # ACT45 has a bend behind it, act1 and act01 are actuators
    digits = at(i + 1, columns).partition(".")[0]
    numbered = told == "act" and digits.isdigit() and (len(digits) == 1 or digits[0] == "0")
    return numbered or any(_way(k, columns) not in ("", told) for k in range(len(columns)) if k != i)


def _way(k: int, columns: Columns) -> str:
    """Return the system that a part of the names says in other words (``loop``, ``two_pass``), an empty text where it says none."""
    part = at(k, columns)
    if (times := next((part[: -len(p)] for p in _PASSES if part.endswith(p)), None)) in _TIMES:
        return _TIMES[times]
    behind = next_word(k, 1, columns)
    if part in _TIMES and behind is not None and at(behind, columns).startswith(_PASSES):
        return _TIMES[part]
    return next((system for system, begins in _WAYS.items() if part.startswith(begins)), "")

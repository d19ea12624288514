"""Which column or single value tells the bending configuration: of several that may, the one that tells most, and what is to be asked."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise

from sstl_cli.importers.guess_words import unaccented, words

# in small letters, as parts of the name of a column: one of these tells a bend or a configuration
BEND = words(
    "bend bends bending bent curvature biegung biegewinkel krummung courbure cintrage flexion curvatura doblado piega 弯曲 弯曲角度 曲げ 曲げ角度"
)
CONFIG = words("config configuration configid cfg konfiguration configuracion configurazione")
# beside these words nothing else than the bend is meant
_PLAIN = words("angle radius deg degree degrees grad rad mm cm m id no nr number name label value level sheath tube catheter guide winkel")
# of a sheath an angle may be its bend
_SHEATH, _ANGLE = words("sheath wrap wrapping tube guaina funda gaine"), words("angle deg winkel grad degrees")
# what a formula calls a bend, with nothing else in the name: theta_deg, R_mm, angle
_LETTERS = words("theta phi angle winkel angulo angolo wrap radius r kappa θ φ")
# an encoder changes sooner than after as many rows
HELD_ROWS = 50
# columns in a question
_SHOWN = 3
# ranks of names: from the first on they may be of something else, the last are
_UNSURE, _LETTER, _NONE = 2, 4, 5


def config_columns(names: Collection[str], alone: Collection[str], paths: bool) -> list[str]:
    """Return the columns whose names may tell the configuration, those that say it in so many words first.

    Parameters
    ----------
    names : collection of str
        Columns of a file.
    alone : collection of str
        Those that hold one value for the whole file.
    paths : bool
        Whether the names are paths, of which the last part counts.

    Examples
    --------
    >>> config_columns(["F_in", "sheath_angle_deg", "bend radius [mm]", "config_id"], [], False)
    ['config_id', 'bend radius [mm]', 'sheath_angle_deg']
    """
    ranks = {n: _rank(_words(n, paths or n in alone)) for n in names}
    return sorted((n for n in names if ranks[n] < _NONE), key=lambda n: ranks[n])


def chosen_config(held: Mapping[str, Sequence[str]], paths: bool) -> tuple[str, str]:
    """Return which of some columns tells the configuration, by what each holds row by row, and the question that is left (empty: none).

    Examples
    --------
    >>> chosen_config({"config": ["a", "b"], "bend_deg": ["20", "65"]}, False)
    ('config', '')
    >>> chosen_config({"bend1_deg": ["30", "30"], "bend2_deg": ["20", "65"]}, False)
    ('bend2_deg', "'bend2_deg' or 'bend1_deg': which tells the bending configuration?")
    """
    whole = [n for n in held if all(_tells(held[n], other) for other in held.values())]
    name = next(iter(whole or held))
    rank = _rank(_words(name, paths))
    if len(held) > 1 and (rank > 0 or not whole):
        shown = " or ".join(map(repr, [name, *(n for n in held if n != name)][:_SHOWN]))
        return name, f"{shown}: which tells the bending configuration?"
    return name, "" if rank < _UNSURE else "does it tell the bending configuration? If not, take this line out"


def labelling(held: Mapping[str, Sequence[str]], paths: bool) -> dict[str, Sequence[str]]:
    """Return the columns that may tell the configuration by what they hold: an angle that does not say of what only beside nothing better, and where it stays for long.

    Examples
    --------
    >>> list(labelling({"bend_deg": ["30"], "R_mm": ["50"]}, False)), list(labelling({"R_mm": ["50"], "angle": ["1", "2"]}, False))
    (['bend_deg'], ['R_mm'])
    """
    ranks = {n: _rank(_words(n, paths)) for n in held}
    best = {n: v for n, v in held.items() if ranks[n] < _LETTER}
    return best or {n: v for n, v in held.items() if len(v) >= HELD_ROWS * sum(a != b for a, b in pairwise(v))}


def says_config(name: str) -> bool:
    """Return whether a name is that of a configuration, which nobody measures."""
    return bool(CONFIG.intersection(_words(name, last=False)))


def _rank(parts: Sequence[str]) -> int:
    """Return 0 for a name of a configuration, 1 for one of a bend, 2 to 4 for one that may be of something else, 5 for one of neither."""
    held = {p for p in parts if not p.isdigit()}
    rest = held - BEND - CONFIG - _PLAIN
    if held & CONFIG:
        return 2 if rest else 0
    if held & BEND:
        return 2 if rest else 1
    if held & _SHEATH and held & _ANGLE:
        return 3
    return _LETTER if held & _LETTERS and not held - _LETTERS - _PLAIN - _SHEATH - {"total", "tot"} else _NONE


def _words(name: str, last: bool) -> list[str]:
    """Return the words of a name in small letters, of a path those of its last part."""
    own = re.split(r"[./]", name)[-1] if last else name
    return [unaccented(w).lower() for w in re.findall(r"[^\W\d_]+|\d+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", own.replace("°", "deg")))]


def _tells(one: Sequence[str], other: Sequence[str]) -> bool:
    """Return whether a column tells all that another does: to each of its values belongs one of the other's."""
    return len(set(zip(one, other, strict=False))) == len(set(one))

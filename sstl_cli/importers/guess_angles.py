"""Which numbers of file names stand beside a word or a sign of an angle, and where these may be of something else."""

from __future__ import annotations

from sstl_cli.importers.guess_parts import TRIAL, Columns, at, before, next_word, next_words
from sstl_cli.importers.guess_words import words

# behind a number these are its unit
_DEGREES = words("deg degree degrees grad gradi grados degres")
_RADIANS = words("rad pi")
_SIGNS = ("°", "º", "˚")
_BENT = words(
    "bend curve radius bending biegung bieg winkel kurve curvature courbure courbe cintrage flexion angulo angle "
    "curva curvatura doblado piega piegatura angolo bogen arco krummung kruemmung biegewinkel courbures 弯曲 彎曲 曲げ 湾曲 굽힘"
)
# in front of a number, or right behind it, one of these tells a bend
BEND = _BENT | _DEGREES | words("config cfg conf r")
# in front of a number, what a formula calls an angle, of the sheath or of anything
LETTERED = _RADIANS | words("theta phi alpha beta ang wrap θ ϑ φ ϕ α β")
# in front of a number that is the same in all names these count or measure something else
COUNTED = words(
    "exp experiment try attempt subject sub sample specimen rig robot sheath tube sensor tendon seil cable wire v vel speed f freq hz ch day "
    "session series serie block batch user person patient version ver rev cycle rep 第 jan feb mar apr may jun jul aug sep oct nov dec"
)
# angles of something else than the sheath
TURNS = words("roll pitch yaw twist tilt tip rot rotation torsion phase knob")
# between a number and its decimals, where no dot may stand in a name
DECIMAL = words("p d pt point dot komma comma ,")
_TEMPERATURES = words("c f k celsius fahrenheit")
# with fewer a number behind a bend counts takes, with more it is a date or the count of a recorder
_ANGLE_DIGITS, _YEAR_DIGITS = (2, 3), 4


def angle_behind(i: int, columns: Columns) -> str:
    """Return the word or sign behind a number that makes it an angle, over a blank or the like too, an empty text where none does.

    Examples
    --------
    >>> [angle_behind(0, [(p,) for p in name]) for name in (("45", " ", "deg"), ("45", "°"), ("1", "_", "deg", "45"), ("30", "deg", "_", "s"))]
    ['deg', '°', '', '']
    """
    direct = at(i + 1, columns)
    if any(sign in direct for sign in _SIGNS):
        return "°"
    k = next_word(i, 1, columns)
    if k is None or _speed(k, columns):
        return ""
    word = at(k, columns)
    if k == i + 1:
        return word if word in BEND | _RADIANS else ""
    # 1_deg45 and 3_bend_45: the word is that of the number behind it; run 3 and sheath 2 count
    own = at(k + 1, columns)[:1].isdigit() or (word in _BENT and _number_behind(k, columns) != "")
    counts = before(i, columns) in COUNTED | TRIAL
    return word if word in _DEGREES | _RADIANS | _BENT and not own and not counts else ""


def unit_of_other(i: int, columns: Columns) -> bool:
    """Return whether the word in front of a number is the unit of another one (``30deg_2``, ``30_deg_2``)."""
    word = i - 1 if at(i - 1, columns)[:1].isalnum() else i - 2
    first = next_word(word, -1, columns)
    return at(word, columns) in _DEGREES and first is not None and at(first, columns)[:1].isdigit() and angle_behind(first, columns) != ""


def angle_doubt(i: int, columns: Columns) -> str:
    """Return the question that the words beside a bend leave, an empty text where they leave none.

    Examples
    --------
    >>> [angle_doubt(2, [(p,) for p in name]) for name in (("bend", "_", "0.5", "pi"), ("bend", "_", "45", "_", "90"))]
    ['is 0.5 the bend in pi? Its label says no unit', 'is 45_90 one bend, or does 90 tell something else?']
    """
    part, front, unit = columns[i][0], before(i, columns), angle_behind(i, columns)
    if at(i - 1, columns) in DECIMAL and at(i - 2, columns)[:1].isdigit():
        return f"is {at(i - 2, columns)}{at(i - 1, columns)}{part} one number?"
    word = next_word(i, 1, columns)
    k = i + 1 if unit == "°" else word if unit and word is not None else i
    # between a number and the next °C, C stands behind the sign
    if unit in _DEGREES | {"°"} and at(next_word(k, 1, columns) or k, columns) in _TEMPERATURES:
        return f"is {part} the bend, or a temperature?"
    if unit in _RADIANS or front in _RADIANS:
        return f"is {part} the bend in {unit or front}? Its label says no unit"
    if front in LETTERED and not unit:
        return f"does {part} behind '{front}' tell the bending configuration? If not, take config_id out"
    if unit in _BENT and k != i + 1 and front not in BEND:
        return f"does {part} in front of '{unit}' tell the bending configuration? If not, take config_id out"
    other = _number_behind(k, columns)
    if unit in _DEGREES and k != i + 1 and other and len(set(columns[i])) == 1 and float(other) > float(part):
        return f"is {part} {unit} the bend, or {other} behind it?"
    if not unit and len(other) >= _ANGLE_DIGITS[0] and other[0] != "0":
        return f"is {part}{at(i + 1, columns)}{other} one bend, or does {other} tell something else?"
    return ""


def _number_behind(i: int, columns: Columns) -> str:
    """Return the number behind a place, over what separates them, that may be an angle as well; an empty text for none, one that varies or has a unit, and a date."""
    k = next_word(i, 1, columns)
    if k is None or k == i + 1 or not at(k, columns)[:1].isdigit() or len(set(columns[k])) > 1 or at(k + 1, columns)[:1].isalpha():
        return ""
    following = next_words(k, columns)[:2]
    # by its year: 60_90_120 are three more
    dated = len(following) == 2 and all(map(str.isdigit, following)) and len(following[1]) == _YEAR_DIGITS
    return at(k, columns) if not dated and len(at(k, columns)) <= _ANGLE_DIGITS[1] else ""


def _speed(i: int, columns: Columns) -> bool:
    """Return whether the unit at a place goes on as that of a speed: deg_per_s, deg_s."""
    following = [p for p in (at(k, columns) for k in range(i + 1, i + 5)) if p and p[0].isalnum()]
    # s1 is the first subject, or sample
    return following[:1] in (["per"], ["sec"]) or (following[:1] == ["s"] and not any(p[0].isdigit() for p in following[1:2]))

"""Numbers and words of file names that may tell a bend, though no word that is known says so."""

from __future__ import annotations

from sstl_cli.importers.guess_angles import COUNTED, DECIMAL, TURNS
from sstl_cli.importers.guess_parts import TRIAL, Columns, at, before, next_words
from sstl_cli.importers.guess_words import QUANTITY_OF, REFERENCE, SIDE_OF, words
from sstl_cli.importers.systems import SYSTEM_OF

MOTIONS = words("sine sin sinus tri triangle ramp step steps chirp random trap trapezoid sweep multisine hold cycle")
# in front of a label, or behind it, these say that it does not hold, or only nearly so
DENIES_BEHIND = words(
    "off removed disabled inactive deactivated detached disconnected failed missing aborted excluded entfernt abgeschaltet deaktiviert "
    "aus fehlt desactive desactivado rimosso spento free less"
)
DENIES = DENIES_BEHIND - {"free", "less"} | words(
    "no not non none without wo w o sans sin senza ohne kein keine keinen nicht anti un ex minus instead former pseudo fake quasi mock pre post "
    "before after vor nach avant apres"
)
_NO_BEND = COUNTED | TRIAL | MOTIONS | TURNS | DENIES | REFERENCE | set(QUANTITY_OF) | set(SIDE_OF) | set(SYSTEM_OF)
# in front of a number that counts recordings, where no word of a name says more
_RECORDED = words(
    "log logs logger data daten datos donnees dati capture record recording rec aufnahme messung mesure medida misura scan trace wave waveform export "
    "sheet tabelle table page part teil csv txt xlsx raw bin id channel kanal step stage untitled unnamed new copy kopie copie copia tek scope osc tmp temp"
)
_STRAIGHT = words("straight unbent gerade gestreckt droit droite rectiligne recto recta dritto diritto rettilineo curved bent gebogen")
# a number with more digits is a date or the count of a recorder
BEND_DIGITS = 3
# bends are multiples of so many degrees, or have decimals such as these
_TURN_DEG = 360
ROUND_DEG, DECIMALS = 5, {"0", "5", "25", "50", "75"}


def maybe_bends(columns: Columns) -> list[int]:
    """Return the places of numbers, the same in all names, behind a word that may call a bend in any language (``bocht30``), the largest first."""
    found = []
    for i, values in enumerate(columns):
        digits, touching = values[0].partition(".")[0], at(i - 1, columns)[-1:]
        # ACT45, act_45 and 45_act, where act1 and act01 number actuators
        beside = {before(i, columns), *next_words(i, columns)[:1]}
        by_system = bool(beside & set(SYSTEM_OF)) and len(digits) > 1 and digits[0] != "0"
        if len(set(values)) > 1 or not digits.isdigit():
            continue
        if not by_system and (not touching.isalpha() or before(i, columns) in _NO_BEND):
            continue
        # 07 counts, 5N and 2Hz have a unit of their own, 0p2 goes on from a number
        counts = len(digits) > BEND_DIGITS or (len(digits) > 1 and float(digits) < 10)
        own_unit = at(i + 1, columns)[:1].isascii() and at(i + 1, columns)[:1].isalpha()
        goes_on = before(i, columns) in DECIMAL and at(i - 2, columns)[-1:].isdigit()
        if not (counts or own_unit or goes_on):
            found.append(i)
    return sorted(found, key=lambda i: -float(columns[i][0]))


def perhaps_bends(columns: Columns) -> list[int]:
    """Return the places of numbers that a bend is usual at, the same in all names, behind a word that counts nothing (``essai_coude_45``)."""
    found = []
    for i, values in enumerate(columns):
        front, (whole, _, decimals) = before(i, columns), values[0].partition(".")
        usual = whole.isdigit() and whole[0] != "0" and 1 < len(whole) <= BEND_DIGITS and int(whole) <= _TURN_DEG
        usual = usual and (decimals in DECIMALS if decimals else int(whole) % ROUND_DEG == 0)
        own_unit = at(i + 1, columns)[:1].isalpha()
        if (
            len(set(values)) == 1
            and usual
            and not own_unit
            and front[:1].isalpha()
            and len(front) > 1
            and front not in _NO_BEND | _RECORDED
        ):
            found.append(i)
    return found


def straight_place(columns: Columns) -> int | None:
    """Return the place of a word, the same in all names, for a sheath that is bent or not, None where there is none."""
    return next((i for i, values in enumerate(columns) if len(set(values)) == 1 and at(i, columns) in _STRAIGHT), None)

"""What stands beside forces that their readings may still need: a zero, a factor, a gain, an exchange of channels that is not said to be done."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.units import unit_of
from sstl_cli.importers.base import Channel
from sstl_cli.importers.guess_marks import asking
from sstl_cli.importers.guess_names import Said
from sstl_cli.importers.guess_unit_columns import may_be_force, said_of
from sstl_cli.importers.guess_words import unaccented, words
from sstl_cli.importers.rates_said import LONGEST
from sstl_cli.importers.text_header import stated_unit
from sstl_cli.importers.units_said import shown, sides_said

Array = NDArray[np.float64]
# what a reading is less, and what it is to be multiplied by
_ZEROS = words(
    "offset offsets tare tara tared taring zero zeroing zeros nullpunkt nullabgleich nullwert nullung zeropoint decalage desfase bias"
)
_FACTORS = words(
    "gain gains scale scaling scalefactor factor faktor skalierung skalierungsfaktor verstarkung verstaerkung facteur factor fattore amplification"
)
_CALIBRATED = words(
    "correction corrections korrektur baseline calibration calibrations calibrated calibrate kalibrierung kalibriert kalibrierfaktor etalonnage calibracion taratura calibrazione uncalibrated unkalibriert"
)
_DONE = words(
    "applied removed subtracted corrected compensated zeroed included deducted done yes abgezogen berucksichtigt beruecksichtigt angewandt angewendet "
    "verrechnet korrigiert kompensiert ja soustrait soustraite applique appliquee corrige corrigee deduit oui restado aplicado aplicada corregido si "
    "sottratto applicato corretto undone calibrated kalibriert tared genullt tariert"
)
_OPEN = words(
    "not nicht no non never ohne without sans sin senza pas missing pending todo later noch still must should needs need remains kein keine "
    "off disabled unapplied uncorrected uncalibrated unkalibriert unscaled raw"
)
_TO_BE = re.compile(r"\b(?:to|will) be\b|\bto apply\b|\bzu \w+en\b|\ba appliquer\b|\bpor aplicar\b|\bda applicare\b")
_TO_DO = words("multiply subtract divide multiplizieren abziehen dividieren soustraire multiplicar restar moltiplicare sottrarre")
_NONE = words("none keine aucun aucune ninguno nessuno")
# of a clock, a place or a picture, not of a force
_OF_ELSE = words(
    "time clock zeit temps trigger delay position pos displacement weg encoder angle winkel motor temperature temp horizontal vertical hor vert display "
    "screen axis date datum due file datei certificate cert zertifikat timezone utc gmt byte bytes header row rows line lines column columns index full ni wf "
    "range position stroke x linear auto lead bend config seed version phase current pid kp ki kd speed velocity"
)
_DATED = re.compile(
    r"\d{4}-\d|\d{1,2}[./]\d{1,2}[./]\d{2,4}|\d{4}[./]\d|\b(?:jan|feb|mar|apr|may|mai|jun|jul|aug|sep|o[ck]t|nov|de[cz])[a-z]*\b"
)
# what comes after the numbers of a word
_NEXT = re.compile(r"[;|,]\s*(?=[^\W\d_])")
# of a gain that is none of newtons, or only about a zero
_HARDLY = words("amplifier verstarker amp preamp adc pga hx ads ina conditioner bridge safety drift")
_NUMBER = re.compile(r"(?<![\w.:-])[-+]?\d+(?:[.,]\d+)?(?:e[-+]?\d+)?(?![\w:]|[.,]\d)")
_SWAPPED = re.compile(
    r"\b(?:swapped|interchanged|vertauscht|verwechselt|mis-?label\w*|wrongly label\w*|intervertis?|interverties|scambiat[ei]|intercambiad[oa]s)\b"
)
_NOT_SWAPPED = words("not nicht no never back corrected fixed undone korrigiert ne non pas")
_CHANNELS = words(
    "channel channels kanal kanale kanaele column columns spalte spalten force forces cell cells sensor sensors signal signals label labels names input "
    "output inputs outputs in out fin fout tension tensions kraft krafte voies voie colonnes canales columnas canali colonne"
)
# 5 N/V, 2.5 mN per count, 1 V = 5 N
_SENSITIVITY = re.compile(
    r"\d[\d.,]*\s*([^\W\d_]{1,4})\s*(?:/|\b(?:per|pro|par|por)\b)\s*(?:m?V|volts?|counts?|digits?|bits?|lsb|inc)\b"
    r"|\d\s*(?:m?V|volts?|counts?|digits?|bits?|lsb)\s*=\s*\d[\d.,]*\s*([^\W\d_]{1,4})\b"
)
# of a column: what another one is to be corrected by
_BESIDE = _ZEROS - words("zeroing tared taring") | _FACTORS | words("correction korrektur")
_MEASURED_ELSE = ("time", "position", "angle", "index", "current", "pressure")


def corrections_said(found: Sequence[Channel], remarks: Iterable[str]) -> dict[str, str]:
    """Return a question for forces of which a line above the table says a zero, a factor or an exchange, and not that this was done.

    Parameters
    ----------
    found : sequence of Channel
        The channels of a file.
    remarks : iterable of str
        Its lines beside them.
    """
    asked: dict[str, str] = {}
    for line in remarks:
        if ask := open_correction(line[:LONGEST]):
            sides = sides_said(line)
            for channel in found:
                one = said_of(channel)
                if not channel.text and may_be_force(one) and one.side in ("", *sides):
                    asked.setdefault(channel.name, f"the file says {shown(line)}: {ask}")
    return asked


def open_correction(line: str) -> str:
    """Return what is to be asked of a line that says how readings of forces are to be corrected, an empty text where it says none, or that it was done.

    Examples
    --------
    >>> open_correction("# Zero offset Fin: 0.35 N (not removed)"), open_correction("# Tare: 0.35 N subtracted")
    ('is that in these readings already?', '')
    >>> open_correction("# Fin and Fout were swapped in this file"), open_correction("# Offset: 0.0 N")
    ('are the names of input and output right?', '')
    """
    cased = unaccented(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", line))
    plain = cased.lower()
    told = set(re.findall(r"[^\W\d_]+", plain))
    if _SWAPPED.search(plain) and told & _CHANNELS and not told & _NOT_SWAPPED:
        return "are the names of input and output right?"
    left = bool(told & _OPEN) or _TO_BE.search(plain) is not None
    if told & _DONE and not left:
        return ""
    ask = "is that in these readings already?"
    sensed = _SENSITIVITY.search(cased)
    if sensed and unit_of(stated_unit(sensed[1] or sensed[2]) or "s")[0] == "force":
        return ask
    if told & _OF_ELSE:
        return ""
    zero, factor, calibrated = (bool(told & known) for known in (_ZEROS, _FACTORS, _CALIBRATED))
    if told & _TO_DO:
        return ask
    if not (zero or factor or calibrated) or told & _NONE:
        return ""
    if left:
        return ask
    dated = _DATED.search(plain) is not None or bool(told & _HARDLY)
    return ask if not dated and (zero or factor) and _tells_more(plain) else ""


def _tells_more(plain: str) -> bool:
    """Return whether a zero in a line is another than 0, or a factor another than 1: the numbers behind their words, else those of the line."""
    found = [m for m in re.finditer(r"[^\W\d_]+", plain) if m[0] in _ZEROS | _FACTORS]
    # Sampling: 100 Hz; Gain: 1.0
    behind = [(m[0], _numbers(_NEXT.split(plain[m.end() :])[0])) for m in found]
    told = [(word, held) for word, held in behind if held] or [(m[0], _numbers(plain)) for m in found]
    return any(held - ({0.0} if word in _ZEROS else {0.0, 1.0}) for word, held in told)


def _numbers(part: str) -> set[float]:
    """Return the numbers in a part of a line."""
    # Gain,1,1: cells, and no decimals
    cells = part.replace(",", ";") if re.match(r"[^\d]*,", part) else part
    return {float(n.replace(",", ".")) for n in _NUMBER.findall(cells)}


def joined(*asked: Mapping[str, str]) -> dict[str, str]:
    """Return all questions for each channel."""
    return {name: "; ".join(a[name] for a in asked if name in a) for name in dict.fromkeys(n for a in asked for n in a)}


def with_corrections(names: Sequence[Said], data: Mapping[str, Array]) -> list[Said]:
    """Return what names say, with a question for forces beside a channel that is called a zero or a factor of their side, and is neither 0 nor 1 throughout."""
    asked: dict[str, str] = {}
    for one in names:
        if not corrects(one):
            continue
        told = _BESIDE.intersection(one.words)
        values = data.get(one.name, np.empty(0))
        held = np.unique(values[np.isfinite(values)])
        if not len(held) or set(held.tolist()) <= ({0.0} if told & _ZEROS else {0.0, 1.0}):
            continue
        for force in names:
            if force is not one and may_be_force(force) and not force.unmeasured and (not one.side or force.side in ("", one.side)):
                asked.setdefault(force.name, f"'{one.name}' stands beside it: is that in these readings already?")
    return [asking(s, asked.get(s.name, "")) for s in names]


def corrects(one: Said) -> bool:
    """Return whether a channel is called a zero or a factor that may be that of a force: its name says so, or a side, or nothing else."""
    if not _BESIDE.intersection(one.words):
        return False
    if one.quantity in _MEASURED_ELSE or one.dimension in ("time", "length", "angle", "pressure") or one.reference:
        return False
    return one.quantity == "force" or bool(one.side) or set(one.words) <= _BESIDE | {"log", "data"}

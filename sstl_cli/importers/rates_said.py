"""A sampling rate, or its interval, as lines above a table state it (``Sample rate: 500 Hz``, ``Fs=100Hz``, ``Sample Interval (s),0.01``)."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from sstl_cli.core.units import unit_of
from sstl_cli.importers.guess_words import UNIT_WORDS, unaccented

# of a line, as a pattern takes its time with blanks
LONGEST = 1_000
_NUMBER = r"\"?(\d+(?:[.,]\d+)*(?:e[-+]?\d+)?)\"?"
_TO = r"\s*[=:,;\t]\W*"
_SAMPLED = (
    r"(?:sampl\w*|scan\w*|abtast\w*|mess|acquisition|d'echantillonnage|echantillonnage|muestreo|campionamento|logging|采样|サンプリング)"
)
_RATE_WORD = r"(?:rate|freq\w*|frequenz|频率|周波数)"
_HZ = r"(k?)\s*(?:hz|s/s|sps|samples?/s(?:ec)?|samples per second)(?![a-z])"
# what is sampled at; Hz alone may be that of the motion, and FS the full scale
_RATED = rf"(?:{_SAMPLED}\W*(?:at|{_RATE_WORD})?|{_RATE_WORD}\W*(?:d[ei]l?\W*)?{_SAMPLED}|frecuencia de muestreo|\bf_?s\b(?=\s*[=:(\[])|^\W*(?:data\W*)?rate)"
# FS = 500 may be a full scale as well; with the unit behind the number, in brackets behind the word, or in the word itself; a number alone only where no other unit is usual
_RATES = (
    re.compile(rf"{_RATED}\W*{_NUMBER}\s*{_HZ}"),
    re.compile(rf"{_RATED}\s*[(\[]\s*{_HZ}\s*[)\]]\"?{_TO}{_NUMBER}"),
    re.compile(rf"(?<![\w.,]){_NUMBER}\s*(k?)(?:samples?/s(?:ec)?|samples per second|sps)(?![a-z])"),
    re.compile(rf"(?:samples per second|{_SAMPLED}[_ ]?{_RATE_WORD}){_TO}{_NUMBER}()[\s,;]*$"),
)
_TIMED = r"(?:d_?t|delta[ _]?t|δt)"
# a period or a time alone may be that of the motion, or the length of the test
_INTERVAL = rf"(?:(?<![a-z]){_TIMED}|{_SAMPLED}\W*(?:time|period\w*|interval\w*|zeit|intervall)|messintervall|(?:log\w*|record\w*|time)\W*interval|^\W*interval)"
_SECONDS = r"(ms|msecs?|us|usecs?|s|secs?|seconds?|milliseconds?|microseconds|min)(?![a-z])"
_PERIODS = (
    re.compile(rf"{_INTERVAL}{_TO}{_NUMBER}\s*{_SECONDS}"),
    re.compile(rf"{_INTERVAL}\s*[(\[]\s*{_SECONDS}\s*[)\]]\"?{_TO}{_NUMBER}"),
)
# an oscilloscope counts these in s: "tInc = 4.0e-09"
_INCREMENT = re.compile(rf"\b(?:t_?inc\w*|increment|sample interval){_TO}{_NUMBER}[\s,;]*(?:s\b.*)?$")


def rate_said(lines: Sequence[str]) -> float:
    """Return the sampling period (s) that a line above the data states, NaN where none or several do, or 1,000 may be a thousand or one.

    Examples
    --------
    >>> [rate_said([x]) for x in ("Sampling rate: 500 Hz", "fs = 0.5 kHz", "dt = 2 ms", "Sample Interval (s),0.002", "SampleRate=500")]
    [0.002, 0.002, 0.002, 0.002, 0.002]
    >>> [rate_said([x]) for x in ("sine of 0.5 Hz", "FS 500 N", "Sampling rate: 1,000 Hz", "Update rate: 60 Hz")]
    [nan, nan, nan, nan]
    """
    steps = {step for line in lines for step in _steps(unaccented(line[:LONGEST].replace("µ", "u").replace("μ", "u")).lower())}
    step = steps.pop() if len(steps) == 1 else math.nan
    return step if step > 0.0 else math.nan


def _steps(line: str) -> set[float]:
    """Return the periods (s) that a line in small letters states, of each way to write them."""
    rates = [m.groups() for form in _RATES if (m := form.search(line))]
    # the unit stands before the number or behind it
    steps = {1.0 / rate for a, b in rates if (rate := (_number(b) * _kilo(a) if a in ("", "k") else _number(a) * _kilo(b))) != 0.0}
    periods = [m.groups() for form in _PERIODS if (m := form.search(line))]
    steps |= {_number(b) * _size(a) if a[0].isalpha() else _number(a) * _size(b) for a, b in periods}
    return steps | ({_number(m[1]) for m in [_INCREMENT.search(line)] if m} if not steps else set())


def _kilo(unit: str) -> float:
    return 1e3 if unit else 1.0


def _size(unit: str) -> float:
    return unit_of(UNIT_WORDS.get(unit, unit))[1]


def _number(text: str) -> float:
    """Return a number, NaN where its one comma may stand between thousands."""
    try:
        return math.nan if re.fullmatch(r"[1-9]\d{0,2},\d{3}", text) else float(text.replace(",", "."))
    except ValueError:
        return math.nan

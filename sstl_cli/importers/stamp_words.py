"""Times in words of other languages (``3. Mai 2024``, ``2024年5月3日 下午 2:05:06``, ``2:05:06 p. m.``), written anew with numbers alone."""

from __future__ import annotations

import re
import unicodedata

from sstl_cli.importers.guess_words import unaccented

_NAMES = (
    "jan january januar janner janvier janv enero ene gennaio gen janeiro januari",
    "feb february februar fevrier fevr fev febrero febbraio fevereiro februari",
    "mar march marz maerz mrz mars marzo marco maart mrt",
    "apr april avril avr abril abr aprile",
    "may mai mayo maggio mag maio mei",
    "jun june juni juin junio giugno giu junho",
    "jul july juli juillet juil julio luglio lug julho",
    "aug august aout agosto ago augustus",
    "sep sept september septembre septiembre settembre sett set setembro",
    "oct october oktober okt octobre octubre ottobre ott outubro",
    "nov november novembre noviembre novembro",
    "dec december dezember dez decembre diciembre dic dicembre dezembro",
)
_MONTHS = {name: number for number, names in enumerate(_NAMES, 1) for name in names.split()}
_YEAR_MONTH_DAY = re.compile(r"(\d{4})(?:\s*[年년]\s*|\. )(\d{1,2})(?:\s*[月월]\s*|\. )(\d{1,2})(?:\s*[日일]|\.(?= |$))")
_WEEKDAY = re.compile(
    r"\(?(?:星期|周|週)[一二三四五六日天]\)?|\(?[月火水木金土日]曜日?\)?|\([月火水木金土日월화수목금토일]\)|[월화수목금토일]요일"
)
_WORD = r"[^\W\d_]+"
# a day of the week may stand in front; a year of two digits could be the day
_DAY_MONTH = re.compile(rf"(?:{_WORD}[.,]*\s+)?(\d{{1,2}})(?:\.|er|º)?[-\s/]*(?:de\s+)?({_WORD})\.?[-\s/]*(?:del?\s+)?(\d{{4}})(?!\d)")
_MONTH_DAY = re.compile(rf"(?:{_WORD}[.,]*\s+)?({_WORD})\.?\s+(\d{{1,2}})(?:st|nd|rd|th)?,?\s+(\d{{4}})(?!\d)")
_YEAR_NAMED = re.compile(rf"(\d{{4}})[-\s/]({_WORD})[-\s/](\d{{1,2}})(?!\d)")
# as C writes it: Fri May  3 14:05:06 2024
_YEAR_LAST = re.compile(rf"(?:{_WORD}\s+)?({_WORD})\s+(\d{{1,2}})\s+(\d{{1,2}}:\S+)\s+(\d{{4}})")
_HOURS = re.compile(
    r"(\d{1,2})\s*(?:[时時点點시]|h(?:\s*|(?=\d)))\s*(\d{1,2})\s*(?:[分분]|min|m|')\s*(\d{1,2}(?:[.,]\d+)?)\s*(?:[秒초]|sec|s|'')?(\d*)"
)
_HALVES = {
    "a": re.compile(r"上午|午前|凌晨|早上|오전|(?<![^\W\d_])a\.?\s?m\b\.?", re.IGNORECASE),
    "p": re.compile(r"下午|午後|午后|晚上|오후|(?<![^\W\d_])p\.?\s?m\b\.?", re.IGNORECASE),
}
# between a date and its time, and behind the time
_BETWEEN = re.compile(r"(?<=\d)(?:,\s+|,?\s+(?:um|at|à|a las|alle|ore|om)\s+)(?=\d)", re.IGNORECASE)
_BEHIND = re.compile(r"\s*\b(?:Uhr|Hs?|hrs)\.?$", re.IGNORECASE)


def in_numbers(stamp: str) -> str:
    """Return a time with its date as numbers from the year down, hours and minutes between colons, and am or pm behind them; another text as it is.

    Examples
    --------
    >>> in_numbers("3. Mai 2024 14:05:06,12"), in_numbers("2024年5月3日 下午 2时05分06秒")
    ('2024-5-3 14:05:06,12', '2024-5-3 2:05:06 pm')
    """
    text = " ".join(unicodedata.normalize("NFKC", stamp).split())
    text = _WEEKDAY.sub(" ", _YEAR_MONTH_DAY.sub(r"\1-\2-\3 ", text))
    halves = [half for half, known in _HALVES.items() if known.search(text)]
    if len(halves) == 1:
        text = _HALVES[halves[0]].sub(" ", text)
    text = _HOURS.sub(lambda m: f"{m[1]}:{m[2]}:{m[3]}" + (f".{m[4]}" if m[4] else ""), text)
    text = _with_month(" ".join(text.split()))
    text = _BEHIND.sub("", _BETWEEN.sub(" ", text))
    text = " ".join(text.split())
    return f"{text} {halves[0]}m" if len(halves) == 1 else text


def _with_month(text: str) -> str:
    """Return a time whose date has a month's name with the month as a number, another text as it is."""
    if m := _YEAR_LAST.fullmatch(text):
        text = f"{m[1]} {m[2]} {m[4]} {m[3]}"
    elif m := _YEAR_NAMED.match(text):
        text = f"{m[3]} {m[2]} {m[1]} {text[m.end() :].lstrip(' :T')}"
    for form, (day, month) in ((_DAY_MONTH, (1, 2)), (_MONTH_DAY, (2, 1))):
        m = form.match(text)
        if m and (number := _MONTHS.get(unaccented(m[month]).lower())):
            return f"{m[3]}-{number}-{m[day]} {text[m.end() :].lstrip(' :T')}"
    return text

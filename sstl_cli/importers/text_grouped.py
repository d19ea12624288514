"""Numbers with marks between thousands (``1,234.5``, ``1'234``), written anew without them where a cell shows which mark is which."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import zip_longest

from sstl_cli.importers.text_cells import SPACES, cut, marks_known
from sstl_cli.importers.text_forms import Forms

# blanks of any width and apostrophes, in UTF-8 and as Windows writes them: no decimal sign in any country
_NEVER_DECIMAL = rb"(?:[ ']|\xe2\x80[\x89\xaf\x99]|(?:\xc2)?[\xa0\x92])"
_GROUPS = rb"([+-]?\d{1,3})%b(\d{3})(?:%b(\d{3}))?(?:%b(\d{3}))?"


def grouped_forms(lines: Sequence[str], by: str) -> Forms | None:
    r"""Return the form of a table some of whose numbers have marks between thousands; None where none shows it, or two show it differently.

    A cell such as ``1,234``, which may be 1.234 as well, is left as it is.

    Parameters
    ----------
    lines : sequence of str
        The first lines of the file.
    by : str
        What cuts them into columns.

    Examples
    --------
    >>> grouped_forms(["0;987,5", "1;1.234,5"], ";").line("2;1.235,5"), grouped_forms(["1;1.234"], ";")
    ('2;1235,5', None)
    >>> grouped_forms(["980;987,5", "1.000;1.234,5"], ";").line("1.020;9,5")
    '1020;9,5'
    """
    if by == SPACES:
        return None
    known = {marks_known(c) for line in lines for c in cut(line, by)} - {("", "")}
    punctuation = {mark for mark, _ in known if mark in ".,"}
    decimals = {sign for _, sign in known if sign} | {"." if mark == "," else "," for mark in punctuation}
    if not known or len(decimals) > 1:
        return None
    decimal = re.escape(decimals.pop()).encode() if decimals else b"[.,]"
    never = _groups(_NEVER_DECIMAL) + rb"((?:%b\d*)?)" % decimal
    parts = [never]
    if punctuation:
        sign = punctuation.pop()
        mark = re.escape(sign).encode()
        # with its decimal sign, or with a second mark; where a cell shows both, a mark alone stands between thousands as well
        shown = any(d for m, d in known if m == sign) and _whole_too([cut(line, by) for line in lines], sign)
        alone = _groups(mark) if shown else rb"([+-]?\d{1,3})%b(\d{3})%b(\d{3})(?:%b(\d{3}))?" % ((mark,) * 3)
        parts += [_groups(mark) + rb"(%b\d*)" % decimal, alone]
    cut_at = re.escape(by).encode()
    # of a table cut at commas a comma is a mark only between quotes
    quote = b'"' if by in {m for m, _ in known} | {d for _, d in known} else b'"?'
    pattern = rb"(?m)(^|%b)([ ]*%b[ ]*)(?:%b)(?=[ ]*%b[ ]*(?:%b|\r?$))" % (cut_at, quote, b"|".join(parts), quote, cut_at)
    compiled = re.compile(pattern)
    cells = b"".join(rb"\g<%d>" % i for i in range(1, compiled.groups + 1))
    return Forms(compiled, cells, by)


def _whole_too(rows: Sequence[Sequence[str]], mark: str) -> bool:
    """Return whether each column with cells such as 1.000 holds smaller whole numbers, or cells with both marks, which show what the mark is there."""
    one = re.compile(rf"[+-]?\d{{1,3}}{re.escape(mark)}\d{{3}}")
    for cells in zip_longest(*rows, fillvalue=""):
        held = [c for c in cells if one.fullmatch(c)]
        told = any(re.fullmatch(r"[+-]?\d{1,3}", c) or marks_known(c) != ("", "") for c in cells)
        # 0.125 has a decimal mark
        if held and (not told or any(c.lstrip("+-").startswith("0") for c in held)):
            return False
    return True


def _groups(mark: bytes) -> bytes:
    return _GROUPS % ((mark,) * 3)

"""Lines that hold a record in JSON each, with the same keys throughout, as brokers of messages write them."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Sequence
from typing import Any

from sstl_cli.importers.text_forms import MOST, Forms

# what stands between two marks of JSON
_GAP = r"[ \t]*"
_NUMBER = r"(?:-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|-?Infinity|NaN)"
# a word or a reading that is missing leaves an empty cell; escaped and tabulated texts are no cells of a table
_VALUE = rf'(?:"([^"\\\t]*)"|({_NUMBER}|true|false)|null)'
# of a file, the lines that tell what it is
_SHOWN_LINES = 20
AS_TABLE = "write it as CSV with one column for each name, or as one record a line with the same keys throughout"
# deeper than messages are
_MAX_DEPTH = 8


def json_forms(lines: Sequence[str]) -> Forms | None:
    r"""Return the form of lines with one record each whose keys are the same in most, None where they are not.

    Examples
    --------
    >>> form = json_forms(['{"t": 0.01, "force": {"in": 2.03, "out": null}}'])
    >>> form.names, form.line('{"t": 0.02, "force": {"in": 2.05, "out": 1.5}}')
    (('t', 'force.in', 'force.out'), '0.02\t2.05\t1.5')
    """
    shapes: Counter[tuple[str, tuple[str, ...]]] = Counter()
    for line in lines:
        try:
            record = json.loads(line.rstrip(" ,\t\r"))
        except (ValueError, RecursionError):
            continue
        names: list[str] = []
        if isinstance(record, dict) and (body := _pattern(record, "", names, 0)) and len(set(names)) == len(names):
            shapes[body, tuple(names)] += 1
    if not shapes:
        return None
    (body, found), count = shapes.most_common(1)[0]
    if count < MOST * len(lines) or not found:
        return None
    cells = "\\t".join(rf"\g<{2 * i + 1}>\g<{2 * i + 2}>" for i in range(len(found)))
    return Forms(re.compile(rf"(?m)^{_GAP}{body}[ \t,\r]*$".encode()), cells.encode(), "\t", found, ("",) * len(found))


def is_one_value(lines: Sequence[str]) -> str:
    """Return what the first lines of a file are of, where it holds JSON that is no record a line, an empty text where it does not.

    Examples
    --------
    >>> is_one_value(['[{"t": 0.01}, {"t": 0.02}]']), is_one_value(["[", ' {"t": 0.01},']), is_one_value(['{"t": [0.01,', "0.02]}"])
    ('an array', 'an array', 'one object')
    >>> is_one_value(["[0.01, 2.03]", "[0.02, 2.05]"]), is_one_value(['{"t": 0.01}', '{"t": 0.02}']), is_one_value(["[10:22:33] 2.03"])
    ('an array a line', '', '')
    """
    filled = [x.strip() for x in lines if x.strip()]
    text = "\n".join(filled[:_SHOWN_LINES])
    if re.match(rf"\[\s*(?:\{{|\[|{_NUMBER}\s*,\s*$)", text, re.MULTILINE):
        return "an array"
    if filled and all(re.fullmatch(rf"\[\s*{_NUMBER}\s*(?:,\s*{_NUMBER}\s*)+\],?", x) for x in filled[:_SHOWN_LINES]):
        return "an array a line" if len(filled) > 1 else "an array"
    one = len(filled) == 1 or not all(x.startswith("{") for x in filled[:_SHOWN_LINES])
    return "one object" if one and re.match(r"\{\s*\"", text) else ""


def _pattern(value: Any, name: str, names: list[str], depth: int) -> str:
    """Return a pattern for a value of the same keys, whose leaves are named by the way to them."""
    if depth > _MAX_DEPTH:
        return ""
    if isinstance(value, dict):
        parts = [
            f"{re.escape(json.dumps(k, ensure_ascii=False))}{_GAP}:{_GAP}" + _pattern(v, f"{name}.{k}".lstrip("."), names, depth + 1)
            for k, v in value.items()
        ]
        return rf"\{{{_GAP}" + f"{_GAP},{_GAP}".join(parts) + rf"{_GAP}\}}"
    if isinstance(value, list):
        items = [_pattern(v, f"{name}[{i}]", names, depth + 1) for i, v in enumerate(value)]
        return rf"\[{_GAP}" + f"{_GAP},{_GAP}".join(items) + rf"{_GAP}\]"
    names.append(name)
    return _VALUE

"""``info`` and ``check`` of what ``compensate --stream`` answered, saved as CSV or JSON Lines."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sstl_cli.cli.render import Screen
    from sstl_cli.core.documents.logs import FileInfo
    from sstl_cli.identification.samples import Finding

LONGEST = 256


def is_answers(path: Path) -> bool:
    """Return whether the first line is the header of the answers, or one of them as JSON."""
    from sstl_cli.control.streaming import ANSWER_HEADER

    with open(path, "rb") as file:
        line = file.readline(LONGEST).decode("utf-8", "replace").strip()
    return line == ",".join(ANSWER_HEADER) or _of_json(line) is not None


def findings(path: Path) -> Iterator[Finding]:
    """Yield what is wrong with the answers: lines that are none, commands that are no numbers, input that was lost."""
    from sstl_cli.control.controller import PHASES
    from sstl_cli.identification.samples import FAILURE, REMARK, Finding

    counts: Counter[str] = Counter()
    first: dict[str, int] = {}
    for number, command, phase in _rows(path):
        what = "no answer" if phase not in PHASES else "not a number" if not math.isfinite(command) else "safe command"
        if phase == "SAFE" or what != "safe command":
            counts[what] += 1
            first.setdefault(what, number)
        counts["lines"] += 1
    if not counts["lines"]:
        yield Finding(FAILURE, "no rows", "", 0, "a header and no answer", "save the whole stream")
    for what in ("no answer", "not a number"):
        if counts[what]:
            yield Finding(FAILURE, what, "", counts[what], f"first in line {first[what]}", "save the whole stream")
    if counts["safe command"]:
        detail = f"input lost in {counts['safe command']} of {counts['lines']} lines, first in line {first['safe command']}"
        yield Finding(REMARK, "safe command", "phase", counts["safe command"], detail, "look at what the sensor sent")


def describe(path: Path, screen: Screen) -> FileInfo:
    """Show how many answers there are, their range and phases; return the entry in the document of ``info``."""
    from sstl_cli.control.streaming import ANSWER_HEADER
    from sstl_cli.core.documents.logs import FileInfo

    rows = 0
    phases: Counter[str] = Counter()
    low, high = math.inf, -math.inf
    for _, command, phase in _rows(path):
        rows += 1
        phases[phase] += 1
        if math.isfinite(command):
            low, high = min(low, command), max(high, command)
    screen.say(f"{path.name} holds {rows} answers of compensate --stream, {path.stat().st_size / 1e6:.2f} MB.")
    if low <= high:
        screen.say(f"  command {low:.3f}..{high:.3f} N; " + ", ".join(f"{p} {n}" for p, n in phases.most_common(8)))
    return FileInfo(file=str(path), schema="no schema", version=0, rows=rows, provenance=None, columns=list(ANSWER_HEADER))


def _rows(path: Path) -> Iterator[tuple[int, float, str]]:
    """Yield number of the line, command (N; NaN for what is no number) and phase of each answer."""
    from sstl_cli.control.streaming import ANSWER_HEADER

    with open(path, encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            text = line.strip()
            if number == 1 and text == ",".join(ANSWER_HEADER):
                continue
            # a line that cannot be read at all is answered in the form of CSV
            yield number, *(_of_json(text) or _of_csv(text))


def _of_csv(text: str) -> tuple[float, str]:
    words = text.split(",")
    return _number(words[0]), words[1] if len(words) == 2 else ""


def _of_json(text: str) -> tuple[float, str] | None:
    """Return command and phase of an answer in JSON, None where the text is none."""
    import json

    from sstl_cli.control.streaming import ANSWER_HEADER

    if not text.startswith("{") or len(text) >= LONGEST:
        return None
    try:
        answer = json.loads(text)
    except ValueError:
        return None
    return (_number(answer["t_cmd"]), str(answer["phase"])) if set(answer) == set(ANSWER_HEADER) else None


def _number(value: object) -> float:
    try:
        return float(str(value))
    except ValueError:
        return math.nan

"""Labels that stand in the file itself: in columns of a table that holds several runs, or as the elements of a struct array."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

from sstl_cli.core.runs import PASSES
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.guess_words import words

# names of columns, in small letters and with _ between words, and the label that each may give
LABEL_OF = {
    "system": words("system"),
    "config_id": words(
        "config config_id configid configuration config_no config_nr cfg cfg_id bend bend_id bend_deg konfiguration biegung"
    ),
    "run_id": words("run run_id runid run_no run_nr trial trial_id trialid trial_no trial_nr versuch versuch_nr essai ensayo"),
    "location": words("location"),
    "trajectory": words("trajectory"),
    "tendon": words("tendon tendon_id"),
}
# fewer samples tell nothing of a clock
LEAST_ROWS = 10
_ELEMENT = re.compile(r"((.*)\((\d+)\)\.)([^()]+)")


@dataclass(frozen=True)
class LabelColumn:
    """A label, the column that gives it, and the question that is left (empty: none)."""

    target: str
    column: str
    question: str = ""


def label_names(names: Iterable[str]) -> dict[str, str]:
    """Return which columns may give which label by their names, the first of each.

    Examples
    --------
    >>> label_names(["Trial No", "config", "time (s)"])
    {'run_id': 'Trial No', 'config_id': 'config'}
    """
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
        target = next((t for t, known in LABEL_OF.items() if plain in known), "")
        if target:
            found.setdefault(target, name)
    return found


def label_columns(names: dict[str, str], values: dict[str, list[str]], whole: bool) -> tuple[LabelColumn, ...]:
    """Return the columns that give labels by what they hold.

    Parameters
    ----------
    names : dict
        Columns by the label that they may give.
    values : dict
        What they hold, row by row.
    whole : bool
        Whether that is all of the file.
    """
    out = []
    for target, name in names.items():
        if target == "system" and not set(values[name]) <= set(PASSES):
            continue
        pieces = 1 + _changes(values[name])
        if pieces > 1 and len(values[name]) < LEAST_ROWS * pieces:
            # a reading, which is another in every row
            continue
        question = "does it name the configuration, or is it measured?" if pieces > 1 and re.match("(?i)bend|bieg", name) else ""
        if target == "run_id":
            rows = list(zip(*(values[n] for n in names.values()), strict=True))
            if not _tells_runs(values[name], rows):
                # trial 1 of the next configuration would go on in the run of this one; a clock that begins anew splits them
                continue
            question = "" if whole else "does it tell every run of the file apart? else leave it out: a clock that begins anew splits runs"
        out.append(LabelColumn(target, name, question))
    return tuple(out)


def _changes(values: list[str]) -> int:
    return sum(a != b for a, b in pairwise(values))


def _tells_runs(runs: list[str], rows: list[tuple[str, ...]]) -> bool:
    """Return whether each run stands in one piece and has one set of labels."""
    return 1 + _changes(runs) == len(set(runs)) == len(set(rows))


def rows_of_first(labels: tuple[LabelColumn, ...], values: dict[str, list[str]]) -> int | None:
    """Return the number of rows of the first run, None where the labels do not change or change too soon to tell one."""
    changes = [i for c in labels for i, (a, b) in enumerate(pairwise(values[c.column]), 1) if a != b]
    return min(changes) if changes and min(changes) >= LEAST_ROWS else None


def runs_in(names: list[str]) -> tuple[str, str]:
    """Return the prefix of the first run and the pattern of all, where the elements of a struct array each hold a whole run; else two empty texts.

    Examples
    --------
    >>> runs_in(["r(1).time", "r(1).Fin", "r(1).Fout", "r(2).time", "r(2).Fin", "r(2).Fout"])
    ('r(1).', 'r\\\\(\\\\d+\\\\)\\\\.')
    """
    held: dict[str, dict[str, list[str]]] = {}
    for found in filter(None, map(_ELEMENT.fullmatch, names)):
        held.setdefault(found[2], {}).setdefault(found[1], []).append(found[4])
    for array, elements in held.items():
        tails = list(elements.values())
        known = [said(t) for t in tails[0]]
        # with one side in each they would be tendons, or sensors
        whole = any(s.quantity == "time" for s in known) and {"in", "out"} <= {s.side for s in known if s.tension}
        if len(tails) > 1 and whole and all(set(t) == set(tails[0]) for t in tails):
            return next(iter(elements)), re.escape(array) + r"\(\d+\)\."
    return "", ""

"""Labels that stand in the file itself: in columns of a table that holds several runs, or as the elements of a struct array."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise, takewhile

from sstl_cli.core.errors import SstlError
from sstl_cli.importers.guess_config import says_config
from sstl_cli.importers.guess_names import said
from sstl_cli.importers.guess_words import LEAD, PLACED, words
from sstl_cli.importers.plan import lead_of
from sstl_cli.importers.systems import SYSTEM_OF, known_system
from sstl_cli.importers.text_header import unit_in

# names of columns, in small letters and with _ between words, and the label that each may give; those of a configuration may hold more words
LABEL_OF = {
    "system": words("system"),
    "run_id": words("run run_id runid run_no run_nr trial trial_id trialid trial_no trial_nr versuch versuch_nr essai ensayo"),
    "location": words("location"),
    "trajectory": words("trajectory"),
    "tendon": words("tendon tendon_id"),
}
# fewer samples tell nothing of a clock
LEAST_ROWS = 10
_PARTS = re.compile(r"[A-Za-z]+|\d+|[^A-Za-z\d]+")
_ELEMENT = re.compile(r"((.*)\((\d+)\)\.)([^()]+)")


@dataclass(frozen=True)
class LabelColumn:
    """A label, the column that gives it, the question that is left (empty: none), the systems that one of the system holds, and what it holds."""

    target: str
    column: str
    question: str = ""
    systems: frozenset[str] = frozenset()
    held: frozenset[str] = frozenset()


def label_names(units: Mapping[str, str], alone: Collection[str] = ()) -> dict[str, str]:
    """Return which columns may give which label but the configuration by their names, the first of each.

    Parameters
    ----------
    units : dict
        Columns, and the units that the file states for them.
    alone : collection of str
        Those that hold one value for the whole file: of the path of one (``log.system``) its last part counts.

    Examples
    --------
    >>> label_names({"Trial No": "", "Lead screw (mm)": "mm", "time (s)": "s"})
    {'run_id': 'Trial No', 'lead_mm': 'Lead screw (mm)'}
    >>> label_names({"RunID": ""})
    {'run_id': 'RunID'}
    """
    found: dict[str, str] = {}
    for name, unit in units.items():
        own = re.split(r"[./]", name)[-1] if name in alone else name
        # runId
        plain = re.sub(r"[^a-z0-9]+", "_", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", own).lower()).strip("_")
        target = next((t for t, known in LABEL_OF.items() if plain in known), "")
        if LEAD.intersection(said(name).words) and (unit or unit_in(name)) in ("", "mm"):
            target = "lead_mm"
        if target:
            found.setdefault(target, name)
    return found


def label_columns(
    names: dict[str, str], values: dict[str, list[str]], whole: bool, units: Mapping[str, str], doubts: Mapping[str, str]
) -> tuple[LabelColumn, ...]:
    """Return the columns that give labels by what they hold.

    Parameters
    ----------
    names : dict
        Columns by the label that they may give.
    values : dict
        What they hold, row by row.
    whole : bool
        Whether that is all of the file.
    units : dict
        Units that the file states for columns.
    doubts : dict
        Questions that are known already, by label.
    """
    out = []
    names = {t: n for t, n in names.items() if may_label(t, values[n])}
    for target, name in names.items():
        pieces = 1 + _changes(values[name])
        question = doubts.get(target, "")
        if target == "config_id" and pieces > 1 and not question and not says_config(name):
            question = "does it name the configuration, or is it measured?"
        if target == "lead_mm":
            question = _lead_question(name, units.get(name, ""), pieces > 1 or not whole)
        elif target == "run_id":
            rows = list(zip(*(values[n] for n in names.values()), strict=True))
            if not _tells_runs(values[name], rows):
                # trial 1 of the next configuration would go on in the run of this one; a clock that begins anew splits them
                continue
            question = "" if whole else "does it tell every run of the file apart? else leave it out: a clock that begins anew splits runs"
        systems: frozenset[str] = frozenset()
        if target == "system":
            systems, question = frozenset(map(known_system, values[name])), _system_question(name, sorted(set(values[name])))
        out.append(LabelColumn(target, name, question, systems, frozenset(values[name])))
    return tuple(out)


def _system_question(name: str, held: list[str]) -> str:
    """Return what is left to ask of a column that holds words for systems, an empty text where it can hold nothing else."""
    both = len(set(map(known_system, held))) > 1
    if all(h.strip().lower() in SYSTEM_OF for h in held) and (both or re.split(r"[./@]", name)[-1].strip().lower() == "system"):
        return ""
    said = " and ".join(f"{h!r} as {known_system(h)}" for h in held)
    return f"is {said} the system (act: single pass, sstl: double pass)? If not, take this line out"


def with_systems(label: LabelColumn, held: Collection[str]) -> LabelColumn:
    """Return the label of a system by what all runs of a file hold, where these stand apart (none: as it is)."""
    held = sorted({*label.held, *held})
    if len(held) == len(label.held):
        return label
    unknown = [h for h in held if not known_system(h)]
    ask = (
        f"another run holds {unknown[0]!r}, neither act nor sstl: write it there, or take this line out"
        if unknown
        else _system_question(label.column, held)
    )
    return replace(label, question=ask, systems=frozenset(map(known_system, held)) - {""}, held=frozenset(held))


def holds_systems(texts: list[str]) -> bool:
    """Return whether a column of text holds words for systems and nothing else; ``double`` alone is a type of data."""
    held = set(texts)
    found = set(map(known_system, held))
    return len(texts) > 1 and "" not in found and (len(found) > 1 or not {h.strip().lower() for h in held} & {"single", "double"})


def may_label(target: str, values: list[str]) -> bool:
    """Return whether values of a column may be a label: what is another in every row is a reading."""
    if target == "system" and not all(map(known_system, set(values))):
        return False
    if target == "lead_mm" and not all(map(_is_lead, set(values))):
        return False
    pieces = 1 + _changes(values)
    return pieces == 1 or len(values) >= LEAST_ROWS * pieces


def _is_lead(text: str) -> bool:
    try:
        return math.isfinite(lead_of(text, ""))
    except SstlError:
        return False


def _lead_question(name: str, unit: str, may_change: bool) -> str:
    """Return what is left to ask of a column that is named after a lead screw, an empty text where that is all that it says."""
    if set(said(name).words) - LEAD - PLACED - {"mm"}:
        return "is this how far the lead screw is turned in, and not another length of it?"
    if may_change:
        return "is this set for each run, or measured?"
    return "" if unit or unit_in(name) else "in mm?"


def _changes(values: list[str]) -> int:
    return sum(a != b for a, b in pairwise(values))


def _tells_runs(runs: list[str], rows: list[tuple[str, ...]]) -> bool:
    """Return whether each run stands in one piece and has one set of labels."""
    return 1 + _changes(runs) == len(set(runs)) == len(set(rows))


def rows_of_first(labels: tuple[LabelColumn, ...], values: dict[str, list[str]]) -> int | None:
    """Return the number of rows of the first run, None where the labels do not change or change too soon to tell one."""
    changes = [i for c in labels for i, (a, b) in enumerate(pairwise(values[c.column]), 1) if a != b]
    return min(changes) if changes and min(changes) >= LEAST_ROWS else None


def runs_in(names: list[str], stem: str = "") -> tuple[str, str]:
    r"""Return the prefix of the first run and the pattern of all, where the elements of a struct array each hold a whole run, or all is called after the file.

    Examples
    --------
    >>> runs_in(["r(1).time", "r(1).Fin", "r(1).Fout", "r(2).time", "r(2).Fin", "r(2).Fout"])
    ('r(1).', 'r\\(\\d+\\)\\.')
    >>> runs_in(["act_bend30.t", "act_bend30.Fin"], "act_bend30"), runs_in(["log.t", "log.Fin"], "act_bend30")
    (('act_bend30.', '[A-Za-z]+_[A-Za-z]+\\d+\\.'), ('', ''))
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
    head = _called_after(names, stem)
    shapes = ("[A-Za-z]+" if p[0].isalpha() else r"\d+" if p[0].isdigit() else re.escape(p) for p in _PARTS.findall(head))
    return head, "".join(shapes)


def _called_after(names: list[str], stem: str) -> str:
    """Return what stands in front of all channels where it is the name of the file, or a part of it with a number, an empty text where it is not."""
    shared = "".join(c[0] for c in takewhile(lambda c: len(set(c)) == 1, zip(*names, strict=False))) if len(names) > 1 else ""
    variable = re.match(r"\w*", shared, re.ASCII)
    # MATLAB's variables begin with a letter, and hold no other signs
    own, file = ([p.lower() for p in _PARTS.findall(t) if p.isalnum()] for t in (variable[0].removeprefix("x") if variable else "", stem))
    at = next((k for k in range(len(own), 0, -1) if own[:k] in (file[i : i + k] for i in range(len(file)))), 0)
    if not at or (own[:at] != file and not any(map(str.isdigit, own[:at]))):
        return ""
    parts = re.match(r"x?" + r"[^A-Za-z0-9]*".join(map(re.escape, own[:at])) + r"[_./:]*", shared, re.IGNORECASE)
    # of rec_1 in rec.mat the number goes on; one of the names may be that of the file itself
    return parts[0] if parts and not any(n[parts.end() :][:1].isdigit() or n == parts[0] for n in names) else ""

"""What a gate leaves for a build server: a JUnit file of passed and missed gates, and a Markdown summary."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from sstl_cli.core.errors import printable
from sstl_cli.core.groups import error_of, of_samples

if TYPE_CHECKING:
    from sstl_cli.core.documents.diagnosis import DiagnosisDocument, TendonBlock


def junit(asked: Mapping[str, object], missed: Sequence[str], sentence: str) -> str:
    """Return a JUnit document: one test case a gate that was asked for, or one that passes where none was.

    Parameters
    ----------
    asked : mapping
        Gates by the name of their option, with the bound given; those not given are None.
    missed : sequence of str
        Sentences of the gates that were missed, each beginning with the name of its option.
    """
    given = {name: bound for name, bound in asked.items() if bound is not None} or {"diagnosed": None}
    suite = ElementTree.Element("testsuite", name="sstl diagnose", tests=str(len(given)), failures=str(len(missed)))
    for name, bound in given.items():
        title = name if bound is None else f"{name} {bound}"
        case = ElementTree.SubElement(suite, "testcase", classname="sstl.diagnose", name=printable(title))
        for text in missed:
            if text.partition(":")[0] == name:
                ElementTree.SubElement(case, "failure", message=printable(text)).text = printable(sentence)
    ElementTree.indent(suite)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(suite, encoding="unicode") + "\n"


def markdown(document: DiagnosisDocument, missed: Sequence[str]) -> str:
    """Return the diagnosis as a short Markdown text: verdict, gates, error step by step, places, candidates, tendon by tendon."""
    unit = document.unit or "N"
    out = [f"### sstl diagnose: {document.verdict.status}", "", _plain(document.sentence or document.verdict.why), ""]
    out += [f"- **gate missed**: {_plain(text)}" for text in missed] + ([""] if missed else [])
    if not document.tendons:
        out += _details(document, unit)
    for block in document.tendons or ():
        name = f"tendon {block.tendon}" if block.tendon else "tendon without a name"
        out += [f"#### {_plain(name)}: {block.verdict.status}", "", _plain(block.sentence), "", *_details(block, unit)]
    return "\n".join(out).rstrip("\n") + "\n"


def _details(part: DiagnosisDocument | TendonBlock, unit: str) -> list[str]:
    """Return the tables of a diagnosis, or of one tendon of it."""
    gap, out = part.gap, []
    if gap is not None:
        steps = (
            ("as given", gap.rmse_base_n),
            ("re-tuned", gap.rmse_retuned_n),
            ("with the effect", gap.rmse_with_effect_n),
            ("noise floor", gap.noise_floor_n),
        )
        what = error_of(gap.samples)
        out += _table(["", f"RMSE{' of ' if what else ''}{what} / {unit}"], [(name, _number(value)) for name, value in steps])
    places = sorted(part.where or (), key=lambda r: -r.share_pct)[:5]
    rows = [(r.system, r.phase, r.config_id or "", _number(r.share_pct)) for r in places]
    out += _table(["system", "phase", "configuration", "share of the gap / %"], rows)
    if part.verdict.status != "none":
        first = (part.candidates or ())[:5]
        of = {i: f" ({samples})" for samples, ids in of_samples(first) for i in ids}
        found = [(c.id, _number(c.probability), f"{_number(c.shrink_pct)}{of.get(c.id, '')}") for c in first]
        out += _table(["candidate", "probability", "error falls by / %"], found)
    return out


def _table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> list[str]:
    if not rows:
        return []
    lines = ["| " + " | ".join(_plain(str(c)) for c in row) + " |" for row in [header, *rows]]
    return [lines[0], "|" + "---|" * len(header), *lines[1:], ""]


def _number(value: float | None) -> str:
    if value is None or value != value:
        return "-"
    return "< 0.001" if 0 < abs(value) < 1e-3 else f"{value:.3g}"


def _plain(text: str) -> str:
    """Return text that Markdown shows as it is: run names are data."""
    shown = printable(text)
    for mark in "\\`*_[]<>|":
        shown = shown.replace(mark, "\\" + mark)
    return shown

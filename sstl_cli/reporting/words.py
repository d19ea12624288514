"""A diagnosis in plain words: where, which, how far and how sure."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from sstl_cli.core.errors import printable
from sstl_cli.reporting.documents import interval, mapping, number, rows, texts
from sstl_cli.reporting.inputs import EffectNote

SYSTEMS = {"act": "the actuation tendon", "sstl": "the sensing loop"}
PHASES = {
    "PB": "while pulling, before the far end follows (PB)",
    "PP": "while pulling, as the far end follows (PP)",
    "RB": "while releasing, before the far end follows (RB)",
    "RP": "while releasing, as the far end follows (RP)",
}
Catalogue = Mapping[str, EffectNote]
# no library of cases is large enough to promise more: the sentence of a diagnosis stops there, too
MOST_SURE = 99.0


def unit_of(document: dict[str, Any]) -> str:
    """Return the unit of the ``_n`` fields: the document's own, newtons where it has none."""
    return printable(str(document.get("unit") or "N"))


def title(name: str, catalogue: Catalogue) -> str:
    """Return an effect's title as it stands in a sentence; a class of several keeps its name.

    Examples
    --------
    >>> title("pulley_friction", {})
    'pulley friction'
    """
    note = catalogue.get(name)
    text = note.title if note else name.replace("_", " ")
    # a capital inside the first word is a name (LuGre, SSTL), not the beginning of a sentence
    return text[0].lower() + text[1:] if note and text[1:2].islower() else text


def listed(names: Iterable[str], word: str) -> str:
    """Return names as an English list.

    Examples
    --------
    >>> listed(["a", "b", "c"], "or")
    'a, b or c'
    """
    found = list(names)
    return f" {word} ".join(found) if len(found) < 3 else f"{', '.join(found[:-1])} {word} {found[-1]}"


def sentence(document: dict[str, Any], catalogue: Catalogue | None = None) -> str:
    """Return the document's own sentence; one that an older version wrote without has but its verdict.

    Examples
    --------
    >>> sentence({"verdict": {"status": "identified", "effects": ["pulley_friction"]}})
    "The verdict is 'identified': pulley friction."
    """
    own = document.get("sentence")
    if isinstance(own, str) and own:
        return own
    verdict = mapping(document, "verdict")
    if not verdict.get("status"):
        return "The document holds no verdict."
    named = listed((title(e, catalogue or {}) for e in texts(verdict, "effects")), "and")
    return f"The verdict is '{verdict['status']}'{': ' if named else ''}{named}."


def where(document: dict[str, Any]) -> str:
    """Return the places that hold most of the gap, in words; '' where the document does not say."""
    found = rows(document, "where")
    if mapping(document, "verdict").get("status") == "none":
        return "Nowhere: what is left is noise."
    systems, places = _sums(found, "system"), _sums(found, "phase")
    if not systems or not places:
        return ""
    parts = [f"{share:.0f} % in {SYSTEMS.get(name, name)}" for name, share in systems[:2] if share >= 1]
    phase, share = places[0]
    configs = _sums(found, "config_id")
    tail = f" Largest configuration: {printable(configs[0][0])} ({configs[0][1]:.0f} %)." if len(configs) > 2 else ""
    return f"{', '.join(parts)}. Most of it {PHASES.get(phase, phase)}: {share:.0f} %.{tail}"


def how_far(document: dict[str, Any]) -> str:
    """Return how the error falls, in words, with its interval or the reason why there is none."""
    gap, unit = mapping(document, "gap"), unit_of(document)
    steps = [
        (number(gap.get(key)), text)
        for key, text in (("rmse_base_n", "as given"), ("rmse_retuned_n", "re-tuned"), ("rmse_with_effect_n", "with the effect"))
    ]
    if mapping(document, "verdict").get("status") in ("none", "unknown"):
        steps = steps[:2]
    walk = " → ".join(f"{value:.2g} {unit} {text}" for value, text in steps if value == value)
    floor = number(gap.get("noise_floor_n"))
    found = [f"Error {walk}" if walk else "", f"noise alone is {floor:.2g} {unit}" if floor == floor else ""]
    return "; ".join(f for f in found if f) + "." if any(found) else ""


def shrinkage(document: dict[str, Any]) -> str:
    """Return the fall of the error in per cent with its 95 % interval, or '' where nothing is named."""
    gap = mapping(document, "gap")
    shrink = number(gap.get("shrink_pct"))
    if shrink != shrink or not texts(mapping(document, "verdict"), "effects"):
        return ""
    low, high = interval(gap.get("shrink_ci95_pct"))
    held = "on recordings kept out of the fit" if gap.get("held_out") else "on the recordings it was fitted to"
    span = f" (95 %: {low:.1f} to {high:.1f})" if low == low else ""
    reason = why_null(gap, "shrink_ci95_pct")
    return f"{shrink:.1f} % less{span}, {held}." + (f" No interval: {reason}." if reason else "")


def how_sure(document: dict[str, Any], blind: list[dict[str, Any]]) -> str:
    """Return what the confidence means, and what a sealed check among the inputs says of such verdicts."""
    verdict = mapping(document, "verdict")
    sure = number(verdict.get("confidence"))
    if sure != sure:
        reason = printable(str(verdict.get("confidence_why") or "")).rstrip(".")
        return f"Not stated: {reason}." if reason else "Not stated."
    stated = min(100 * sure, MOST_SURE)
    text = f"{stated:.0f} %: of 100 such verdicts about {stated:.0f} are right."
    for document_ in blind:
        for row in rows(document_, "reliability"):
            right, n = number(row.get("share_right")), number(row.get("n"))
            if number(row.get("p_low")) <= sure <= number(row.get("p_high")) and right == right and n > 0:
                name = printable(str(document_.get("name") or "the sealed check"))
                return f"{text} In {name} {round(right * n)} of {n:.0f} verdicts with this confidence were."
    return text


@cache
def published() -> dict[str, Any]:
    """Return what the published withheld-effect check says of verdicts by their confidence (docs/blind.md)."""
    return dict(json.loads(files("sstl_cli.reporting").joinpath("sealed.json").read_text(encoding="utf-8")))


def why_null(owner: dict[str, Any], key: str) -> str:
    """Return why a value that is null cannot be given: ``KEY_why``, else the owner's ``why``; '' where it is given."""
    if owner.get(key) is not None:
        return ""
    reason = owner.get(f"{key}_why") or owner.get("why") or ""
    return printable(str(reason)).rstrip(".")


def _sums(found: list[dict[str, Any]], key: str) -> list[tuple[str, float]]:
    total: dict[str, float] = {}
    for row in found:
        share = number(row.get("share_pct"))
        if share == share and row.get(key) is not None:
            total[str(row[key])] = total.get(str(row[key]), 0.0) + share
    return sorted(total.items(), key=lambda item: (-item[1], item[0]))

"""A diagnosis in plain words: where, which, how far and how sure."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files

from sstl_cli.core.errors import printable
from sstl_cli.core.groups import below, error_of
from sstl_cli.reporting.diagnosed import Diagnosed, Gap, Parameter, Place
from sstl_cli.reporting.documents import NAN, read
from sstl_cli.reporting.inputs import EffectNote
from sstl_cli.reporting.scored import Scored

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


def unit_of(document: Diagnosed) -> str:
    """Return the unit of the ``_n`` fields: the document's own, newtons where it has none."""
    return printable(document.unit or "N")


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


def sentence(document: Diagnosed, catalogue: Catalogue | None = None) -> str:
    """Return the document's own sentence; one that an older version wrote without has but its verdict.

    Examples
    --------
    >>> sentence(read(Diagnosed, {"verdict": {"status": "identified", "effects": ["pulley_friction"]}}))
    "The verdict is 'identified': pulley friction."
    """
    if document.sentence:
        return document.sentence
    verdict = document.verdict
    if not verdict.status:
        return "The document holds no verdict."
    named = listed((title(e, catalogue or {}) for e in verdict.effects), "and")
    return f"The verdict is '{verdict.status}'{': ' if named else ''}{named}."


def where(document: Diagnosed) -> str:
    """Return the places that hold most of the gap, in words; '' where the document does not say."""
    if document.verdict.status == "none":
        return "Nowhere: what is left is noise."
    systems, places = _sums(document.where, lambda p: p.system), _sums(document.where, lambda p: p.phase)
    if not systems or not places:
        return ""
    parts = [f"{share:.0f} % in {SYSTEMS.get(name, name)}" for name, share in systems[:2] if share >= 1]
    phase, share = places[0]
    configs = _sums(document.where, lambda p: p.config_id)
    tail = f" Largest configuration: {printable(configs[0][0])} ({configs[0][1]:.0f} %)." if len(configs) > 2 else ""
    return f"{', '.join(parts)}. Most of it {PHASES.get(phase, phase)}: {share:.0f} %.{tail}"


def how_far(document: Diagnosed) -> str:
    """Return how the error falls, in words, with its interval or the reason why there is none."""
    gap, unit = document.gap, unit_of(document)
    steps = [(gap.rmse_base_n, "as given"), (gap.rmse_retuned_n, "re-tuned"), (gap.rmse_with_effect_n, "with the effect")]
    if document.verdict.status in ("none", "unknown"):
        steps = steps[:2]
    walk = " → ".join(f"{value:.2g} {unit} {text}" for value, text in steps if value == value)
    floor, what = gap.noise_floor_n, printable(error_of(gap.samples))
    found = [f"Error{' of ' if what else ''}{what} {walk}" if walk else "", f"noise alone is {floor:.2g} {unit}" if floor == floor else ""]
    return "; ".join(f for f in found if f) + "." if any(found) else ""


def shrinkage(document: Diagnosed) -> str:
    """Return the fall of the error in per cent with its 95 % interval, or '' where nothing is named."""
    gap = document.gap
    if gap.shrink_pct != gap.shrink_pct or not document.verdict.effects:
        return ""
    low, high = gap.shrink_ci95_pct or (NAN, NAN)
    held = "on recordings kept out of the fit" if gap.held_out else "on the recordings it was fitted to"
    fall, share, than = gap.shrink_pct, gap.explained_of_reducible_pct, "less"
    if round(fall, 1) < 0.0:
        # nothing is explained of an error that is larger than before
        fall, share, than, low, high = -fall, NAN, "more", -high, -low
    span = f" (95 %: {low:.1f} to {high:.1f})" if low == low else ""
    of = f"; {share:.1f} % of the error above {below(gap.known_misfit_n)}" if share == share else ""
    reason = why_null(gap.shrink_ci95_pct, gap.shrink_why or gap.shrink_ci95_pct_why, gap)
    return f"{fall:.1f} % {than}{span}, {held}{of}." + (f" No interval: {reason}." if reason else "")


def how_sure(document: Diagnosed, blind: Sequence[Scored]) -> str:
    """Return what the confidence means, and what a sealed check among the inputs says of such verdicts."""
    sure = document.verdict.confidence
    if sure != sure:
        reason = printable(document.verdict.confidence_why).rstrip(".")
        return f"Not stated: {reason}." if reason else "Not stated."
    stated = min(100 * sure, MOST_SURE)
    text = f"{stated:.0f} %: of 100 such verdicts about {stated:.0f} are right."
    for scored in blind:
        for row in scored.reliability:
            if row.p_low <= sure <= row.p_high and row.share_right == row.share_right and row.n > 0:
                name = printable(scored.name or "the sealed check")
                return f"{text} In {name} {round(row.share_right * row.n)} of {row.n:.0f} verdicts with this confidence were."
    return text


@cache
def published() -> Scored:
    """Return what the published withheld-effect check says of verdicts by their confidence (docs/blind.md)."""
    return read(Scored, json.loads(files("sstl_cli.reporting").joinpath("sealed.json").read_text(encoding="utf-8")))


def why_null(value: object, own: str, part: Gap | Parameter) -> str:
    """Return why a value that is null cannot be given: its own reason, else that of its part; '' where it is given."""
    return "" if value is not None else printable(own or part.why).rstrip(".")


def _sums(found: Iterable[Place], key: Callable[[Place], str]) -> list[tuple[str, float]]:
    total: dict[str, float] = {}
    for place in found:
        if place.share_pct == place.share_pct and key(place):
            total[key(place)] = total.get(key(place), 0.0) + place.share_pct
    return sorted(total.items(), key=lambda item: (-item[1], item[0]))

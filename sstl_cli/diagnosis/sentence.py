"""The verdict in one plain sentence, and the few lines under it."""

from __future__ import annotations

from typing import Any

from sstl_cli.physics.effects import catalogue


def sentence(document: dict[str, Any]) -> str:
    """Return the answer to 'what causes the gap?' in one sentence."""
    verdict = document["verdict"]
    effects, p = verdict["effects"], verdict["confidence"]
    status = verdict["status"]
    if status == "none":
        return (
            "The simulator already explains the log to its noise floor: nothing is missing that this data could show."
        )
    if status == "unknown":
        return f"There is a gap whose cause is not known: {verdict['why']}."
    names = " and ".join(f"{_plain(e)} ({e})" for e in effects)
    if status == "ambiguous":
        others = [e for e in verdict["ambiguity_group"] if e not in effects]
        return f"The gap comes from {names}, or from {', '.join(others)}: this data cannot tell them apart (p = {p:.2f} together)."
    return f"The gap comes from {names}, p = {p:.2f}."


def _plain(effect_id: str) -> str:
    title = catalogue()[effect_id].title
    return title[0].lower() + title[1:]


def lines(document: dict[str, Any]) -> list[str]:
    """Return the lines that a person reads under the sentence."""
    gap = document["gap"]
    out = [
        f"  {_n(gap['rmse_base_n'])} as given -> {_n(gap['rmse_retuned_n'])} re-tuned -> {_n(gap['rmse_with_effect_n'])} with the "
        f"effect; noise floor {_n(gap['noise_floor_n'])}"
        if document["verdict"]["effects"]
        else f"  {_n(gap['rmse_base_n'])} as given -> {_n(gap['rmse_retuned_n'])} re-tuned; noise floor {_n(gap['noise_floor_n'])}"
    ]
    if document["verdict"]["effects"]:
        low, high = gap["shrink_ci95_pct"]
        held = "held-out error falls" if gap["held_out"] else "error falls (no other excitation to hold out)"
        out.append(
            f"  {held} by {gap['shrink_pct']:.1f} % [{low:.1f}, {high:.1f}]; "
            f"{gap['explained_of_reducible_pct']:.1f} % of what can be explained"
        )
    places: dict[str, float] = {}
    for row in document["where"]:
        key = f"{row['system']} {row['phase']}"
        places[key] = places.get(key, 0.0) + row["share_pct"]
    top = sorted(places.items(), key=lambda item: -item[1])[:3]
    rest = 100.0 - sum(v for _, v in top)
    out.append(
        "  it lies in   " + "   ".join(f"{k} {v:.0f} %" for k, v in top) + f"   elsewhere {max(rest, 0.0):.0f} %"
    )
    group = [e for e in document["verdict"]["ambiguity_group"] if e not in document["verdict"]["effects"]]
    if document["verdict"]["effects"]:
        out.append("  not told apart from it on this data: " + (", ".join(group) if group else "nothing"))
    out += [f"  note: {text}" for text in document.get("notes", [])]
    return out


def _n(value: float | None) -> str:
    return "-" if value is None else f"{value:.2g} N"

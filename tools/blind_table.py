"""Put the score of the published withheld-effect check into docs/blind.md, its targets into README.md, and what the report
quotes of it beside the report.

python tools/blind_table.py SCORE.json [--commit ID] [--set WORDS]
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from page_part import put, table

from sstl_cli.blind.score import SAID
from sstl_cli.blind.strength import STRENGTHS

PUBLISHED = Path(__file__).resolve().parents[1] / "sstl_cli/reporting/sealed.json"


def share(x: dict[str, Any] | None) -> str:
    """Return hits of cases with the Wilson interval in per cent."""
    if not x or not x.get("n"):
        return "-"
    return f"{x['k']} of {x['n']} ({100 * x['low']:.0f}-{100 * x['high']:.0f} %)"


def targets(score: dict[str, Any]) -> str:
    """Return what was aimed at and what came out."""
    sign = {"max": "<=", "min": ">=", "within": "90 +- 5 %, target"}
    rows: list[list[object]] = []
    for t in score["targets"]:
        value = f"{100 * t['value']:.1f} %" if "k" in t else f"{t['value']:.3f}"
        goal = f"{sign[t['rule']]} {100 * t['target']:.0f} %" if "k" in t else f"<= {t['target']:.2f}"
        rows.append([t["name"], value, share(t) if "k" in t else "", goal, "met" if t["met"] else "**missed**"])
    return table(["score", "measured", "cases (95 %)", "target", ""], rows)


def by_strength(score: dict[str, Any]) -> str:
    """Return the scores of each strength, which are never pooled."""
    names = ("isolation", "first_named", "in_group", "said_none", "wrong_commits", "unknown_recall", "both_of_a_pair")
    head = ["gap / noise", "isolated", "named first", "in the group", "said `none`", "wrong commits", "unknown recall", "both of a pair"]
    return table(head, [[f"{s['strength']:g}", *(share(s.get(n)) for n in names)] for s in score["by_strength"] if s["strength"]])


def by_effect(score: dict[str, Any]) -> str:
    """Return isolation by effect, and why the others were missed."""
    rows: list[list[object]] = []
    for e in score["by_effect"]:
        found = e["isolation"].values()
        rows.append([f"`{e['effect']}`", *(f"{x['k']}/{x['n']}" if x else "-" for x in found), e["reason"] or "-"])
    return table(["effect", *(f"{s:g}" for s in STRENGTHS), "misses, and the likely reason"], rows)


def baselines(score: dict[str, Any]) -> str:
    """Return the same cases answered by simpler rules."""
    names = ("isolation", "false_alarm", "wrong_commits", "unknown_recall")
    rows = [[b["name"], *(share(b.get(n)) for n in names)] for b in score["baselines"]]
    return table(["rule", "isolated", "false alarm", "wrong commits", "unknown recall"], rows)


def sides(rows: list[dict[str, Any]]) -> str:
    """Return every rate with one column a simulator, all together last."""
    lines: list[list[object]] = [["cases", *(r["cases"] for r in rows)]]
    lines += [[f"isolated at {s:g} x noise", *(share(r["isolation"][f"{s:g}"]) for r in rows)] for s in STRENGTHS]
    lines += [[f"in the group at {s:g} x noise", *(share(r["in_group"][f"{s:g}"]) for r in rows)] for s in STRENGTHS]
    for name, said in SAID.items():
        lines.append([said, *(_value(r["scores"][name]) for r in rows)])
    return table(["rate", *(r["simulator"] for r in rows)], lines)


def _value(x: Any) -> str:
    return f"{x:.3f}" if isinstance(x, float) else share(x)


def by_d2(score: dict) -> str:
    """Rates in strata of the distance, and what an ideal observer would reach."""
    rows = [
        "| D^2 to base and nearest rival | isolated | ideal observer | in the group | unknown recall | both of a pair |",
        "|---|---|---|---|---|---|",
    ]
    for r in score["by_d2"]:
        span = f"{r['d2_low']:g}-{r['d2_high']:g}" if r["d2_high"] is not None else f"{r['d2_low']:g} and more"
        ideal = "-" if r["ideal"] is None else f"{100 * r['ideal']:.0f} %"
        rows.append(
            f"| {span} | {share(r['isolation'])} | {ideal} | "
            + " | ".join(share(r[k]) for k in ("in_group", "unknown_recall", "both_of_a_pair"))
            + " |"
        )
    return "\n".join(rows)


def published(score: dict[str, Any], commit: str) -> dict[str, Any]:
    """Return what the report says of verdicts by their confidence."""
    keys = ("p_low", "p_high", "n", "mean_p", "share_right")
    rows = [{k: round(r[k], 2) for k in keys} for r in score["reliability"]]
    return {
        "name": "the published sealed check",
        "cases": score["cases"],
        "commit": commit,
        "seal": score["seal"][:16],
        "reliability": rows,
    }


def main() -> None:
    """Fill both pages."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("score", type=Path)
    parser.add_argument("--commit", default="the present version")
    parser.add_argument("--set", dest="words", default="--cases 300")
    given = parser.parse_args()
    score = json.loads(given.score.read_text(encoding="utf-8"))
    kinds = ", ".join(f"{n} {k}" for k, n in sorted(score["kinds"].items()))
    left = f" {score['missing_results']} cases of the set were not run in the time there was." if score["missing_results"] else ""
    reliability = table(
        ["stated confidence", "verdicts", "mean stated", "share right"],
        [[f"{r['p_low']:.1f}-{r['p_high']:.1f}", r["n"], f"{r['mean_p']:.2f}", f"{r['share_right']:.2f}"] for r in score["reliability"]],
    )
    head = f"""`sstl blind make set {given.words}`, diagnosed by {given.commit}: {score["cases"]} cases ({kinds}).{left}
Seal {score["seal"][:16]}; no rule was changed after it was opened. {score["seconds"]["mean"]:.1f} s a case on average, {score["seconds"]["max"]:.0f} s at most.
"""
    group = f"Ambiguity groups hold {score['group']['mean_size']:.1f} effects on average, {score['group']['largest']} at most. Predicted and realised shrinkage differ by {score['shrink_mean_difference_pct']:.1f} points on average."
    poor, wrong = score["poor"], score["wrong_nominal"]
    rest = f"Poor excitation: wrong commits {share(poor['wrong_commits'])}, abstained {share(poor['abstained'])}. Wrong nominal theta: false alarm {share(wrong['false_alarm'])}, isolated {share(wrong['isolation'])}."
    compared = [sides(score["by_simulator"])]
    if score["decidable"] is not None:
        compared += [
            "Cases that their recordings could decide (D^2 of at least 24 to base and nearest rival):",
            sides(score["decidable"]),
            by_d2(score),
        ]
    put(
        "blind.md",
        "published",
        "\n\n".join([head, targets(score), *compared, by_strength(score), by_effect(score), group, rest, reliability, baselines(score)]),
    )
    PUBLISHED.write_text(json.dumps(published(score, given.commit), indent=1) + "\n", encoding="utf-8")
    put("../README.md", "blind", f"{score['cases']} withheld cases ({given.words}), {given.commit}:\n\n{targets(score)}")


if __name__ == "__main__":
    main()

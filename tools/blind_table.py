"""Put the score of the published withheld-effect check into docs/blind.md, its targets into README.md, its rates over D^2 into
docs/limit.md with their picture (docs/isolation.svg), and what the report quotes of it beside the report.

python tools/blind_table.py SCORE.json [--commit ID] [--set WORDS]
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from math import hypot
from pathlib import Path
from typing import Any

from page_part import DOCS, put, table

from sstl_cli.blind.strength import STRENGTHS
from sstl_cli.blind.targets import SAID, WITHIN
from sstl_cli.reporting import drawing
from sstl_cli.reporting.documents import read
from sstl_cli.reporting.figures import distance
from sstl_cli.reporting.scored import Scored

PUBLISHED = Path(__file__).resolve().parents[1] / "sstl_cli/reporting/sealed.json"
# what was asked of a published set: its cases, nulls of each simulator, points that a foreign one may lose, seconds of a long case
CASES, NULLS, MOST_LOST, LONGEST_S = 900, 150, 10, 5.0
OWN, PICTURE = "rig", "isolation.svg"
SHIPPED = """By simulator. The weights are those that ship, learned from libraries of all three simulators: none of these columns is of a simulator
left out, and the results do not keep the rows that other weights would need. Weights on a simulator that they have not seen: [above](#left-out-simulators)."""
LEFT_OUT = """By simulator, each judged by weights that were learned from the other two (thresholds were set once, on all such predictions of the libraries);
every other table of this set is of the weights that ship."""


def share(x: dict[str, Any] | None) -> str:
    """Return hits of cases with the Wilson interval in per cent."""
    if not x or not x.get("n"):
        return "-"
    return f"{x['k']} of {x['n']} ({100 * x['low']:.0f}-{100 * x['high']:.0f} %)"


def targets(score: dict[str, Any]) -> str:
    """Return what was aimed at and what came out; with the size of the set, the foreign simulators and the time a case."""
    rows: list[list[object]] = []
    for t in score["targets"]:
        counted = t.get("k") is not None
        value = "-" if t["value"] is None else f"{100 * t['value']:.1f} %" if counted else f"{t['value']:.3f}"
        spread = share(t) if counted else f"({t['low']:.2f}-{t['high']:.2f})" if t.get("low") is not None else ""
        rows.append([t["name"], value, spread, _goal(t, counted), _met(t["met"])])
    lost = sorted(((r[0], f"{name} {r[0]:.0f} ({simulator})") for name, simulator, r in losses(score)), reverse=True)
    more = "; ".join(said for points, said in lost if points > MOST_LOST)
    goal = f"<= {MOST_LOST} points on each row"
    rows.append(["points that a foreign simulator loses", f"{lost[0][0]:.0f} at most", more, goal, _met(not more)])
    seconds = score["seconds"]
    if seconds["long_mean"] is not None:
        long = f"{seconds['long_cases']} of 50 000 samples and more, beside other work"
        goal = f"<= {LONGEST_S:g} s (60 000 samples, two cores)"
        rows.append(["time a long case", f"{seconds['long_mean']:.1f} s", long, goal, _met(seconds["long_mean"] <= LONGEST_S)])
    nulls = min(r["scores"]["false_alarm"]["n"] for r in score["by_simulator"][:-1])
    rows.append(["cases", score["cases"], "", f">= {CASES}", _met(score["cases"] >= CASES)])
    rows.append(["nulls a simulator", nulls, "", f">= {NULLS}", _met(nulls >= NULLS)])
    return table(["score", "measured", "cases (95 %)", "target", ""], rows)


def _goal(t: dict[str, Any], counted: bool) -> str:
    within = WITHIN.get(t["id"])
    if within is not None:
        return f"{100 * t['target']:.0f} +- {100 * within:.0f} %" if counted else f"{t['target'] - within:.1f}-{t['target'] + within:.1f}"
    by_chance = f", or not above chance ({t['chance']:.3f})" if t.get("chance") is not None else ""
    return f"{'<=' if t['rule'] == 'max' else '>='} " + (f"{100 * t['target']:.0f} %" if counted else f"{t['target']:.2f}") + by_chance


def _met(met: bool | None) -> str:
    return {True: "met", False: "**missed**", None: "no case"}[met]


def by_simulator(score: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the rates of each simulator, by weights that have not seen it where the results keep what those need."""
    found: list[dict[str, Any]] = score.get("left_out") or score["by_simulator"]
    return found


def losses(score: dict[str, Any]) -> list[tuple[str, str, tuple[float, float, float]]]:
    """Return by how many points each foreign simulator does worse than the own rig on each rate, with the interval of Newcombe (1998)."""
    rows = {r["simulator"]: r["scores"] for r in by_simulator(score)[:-1]}
    own = rows.pop(OWN)
    found = []
    for name, said in SAID.items():
        for simulator, scores in rows.items():
            a, b = (own[name], scores[name])
            if isinstance(a, dict) and isinstance(b, dict):
                # of alarms and wrong names more is worse
                a, b = (b, a) if name in ("false_alarm", "wrong_commits") else (a, b)
                lost = a["share"] - b["share"]
                low = lost - hypot(a["share"] - a["low"], b["high"] - b["share"])
                high = lost + hypot(a["high"] - a["share"], b["share"] - b["low"])
                found.append((said, simulator, (100 * lost, 100 * low, 100 * high)))
    return found


def foreign(score: dict[str, Any]) -> str:
    """Return the table of what foreign simulators lose."""
    cells: dict[str, dict[str, str]] = {}
    for said, simulator, (lost, low, high) in losses(score):
        missed = "" if lost <= MOST_LOST else " **missed**" if low > MOST_LOST else " **missed**, not beyond chance"
        cells.setdefault(said, {})[simulator] = f"{lost:.0f} ({low:.0f} to {high:.0f}){missed}"
    simulators = sorted({s for row in cells.values() for s in row})
    rows = [[said, *(row.get(s, "-") for s in simulators)] for said, row in cells.items()]
    return table([f"points lost against the {OWN} (95 %; at most {MOST_LOST})", *simulators], rows)


def calibration(score: dict[str, Any]) -> str:
    """Return stated confidence against what was right, of all cases and of the two kinds, beside what chance shows."""

    def number(row: dict[str, Any], *keys: str) -> list[str]:
        return ["-" if row[k] is None else f"{row[k]:.3f}" for k in keys]

    rows = [
        [r["cases"], r["n"], *number(r, "stated", "right", "ece", "ece_chance", "ece_chance_95"),
         "-" if r["slope"] is None else f"{r['slope']:.2f} ({r['slope_low']:.2f}-{r['slope_high']:.2f})"]
        for r in score["calibration"]
    ]  # fmt: skip
    head = ["cases", "verdicts", "mean stated", "share right", "calibration error", "by chance", "by chance, 95 % point", "slope (95 %)"]
    return table(head, rows)


def confidence(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return in words what the table of calibration says, from its rows: of all cases, then of the two kinds."""
    of_all, *kinds = rows
    low = "too low" if of_all["stated"] < of_all["right"] else "too high"
    # not above what chance shows in 95 of 100 sets nobody can say which it is
    said = f"is stated {low} on this set" if of_all["ece"] > of_all["ece_chance_95"] else "is as often right as it says"
    parts = ", ".join(f"of the {r['n']} cases with {r['cases']} {100 * r['stated']:.1f} % and {100 * r['right']:.1f} %" for r in kinds)
    return (
        f"The confidence {said}: {100 * of_all['stated']:.1f} % on average, and {100 * of_all['right']:.1f} % of the answers are right ({parts}). "
        f"Stated and right differ by {of_all['ece']:.3f} on average (expected calibration error); as many answers that are right exactly as often as they "
        f"say would show {of_all['ece_chance']:.3f} by chance, and more than {of_all['ece_chance_95']:.3f} in 5 of 100 sets."
    )


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


def by_d2(score: dict[str, Any]) -> str:
    """Return rates in strata of the distance, and what an ideal observer would reach."""
    rows = []
    for r in score["by_d2"]:
        span = f"{r['d2_low']:g}-{r['d2_high']:g}" if r["d2_high"] is not None else f"{r['d2_low']:g} and more"
        ideal = "-" if r["ideal"] is None else f"{100 * r['ideal']:.0f} %"
        rows.append([span, share(r["isolation"]), ideal, *(share(r[k]) for k in ("in_group", "unknown_recall", "both_of_a_pair"))])
    head = ["D^2 to base and nearest rival", "isolated", "ideal observer", "in the group", "unknown recall", "both of a pair"]
    return table(head, rows)


def over_distance(score: dict[str, Any], given: argparse.Namespace) -> None:
    """Put the rates over D^2 into docs/limit.md, with their picture."""
    shown = distance.data(read(Scored, score))
    drawing.save(distance, shown, DOCS / PICTURE, "svg", "")
    limit = score["against_limit"]
    text = f"""The published set ([blind.md](blind.md#published-run); {score["cases"]} cases, diagnosed by {given.commit}, seal {score["seal"][:16]}):
of the decidable single effects {share(limit["isolation"])} are named, where an ideal observer would name {100 * limit["ideal"]:.1f} %; of the
single effects and pairs that are not decidable {share(limit["undecidable_in_set"])} are answered by a set that holds the truth.

![Share of single effects over D^2, beside an ideal observer]({PICTURE})

{by_d2(score)}"""
    put("limit.md", "score", text)


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
    compared = [LEFT_OUT if score.get("left_out") else SHIPPED, sides(by_simulator(score)), foreign(score)]
    if score["decidable"] is not None:
        compared += [
            "Cases that their recordings could decide (D^2 of at least 24 to base and nearest rival):",
            sides(score["decidable"]),
            "The same over D^2, beside an ideal observer: [limit.md](limit.md#the-published-score-against-it).",
        ]
    put(
        "blind.md",
        "published",
        "\n\n".join(
            [
                head,
                targets(score),
                *compared,
                by_strength(score),
                by_effect(score),
                group,
                rest,
                calibration(score),
                reliability,
                baselines(score),
            ]
        ),
    )
    if score["by_d2"] is not None:
        over_distance(score, given)
    PUBLISHED.write_text(json.dumps(published(score, given.commit), indent=1) + "\n", encoding="utf-8")
    head = f"{score['cases']} withheld cases ({given.words}), {given.commit}:"
    put("../README.md", "blind", "\n\n".join([head, targets(score), confidence(score["calibration"])]))


if __name__ == "__main__":
    main()

"""How the withheld-effect check looks on a terminal, and its gates."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from sstl_cli.cli.render import Screen

# option -> (score, whether it is an upper bound)
GATES = {
    "max_false_alarm": ("false_alarm", True),
    "min_isolation": ("isolation", False),
    "min_isolation_weak": ("isolation_weak", False),
    "max_wrong_commits": ("wrong_commits", True),
    "min_unknown_recall": ("unknown_recall", False),
    "min_pairs": ("both_of_a_pair", False),
    "max_ece": ("ece", True),
}
MISSES_SHOWN = 12


def gate(name: str) -> Any:
    """Return the annotated type of a gate option."""
    score, upper = GATES[name]
    what = score.replace("_", " ").replace(" weak", " below 0.6 x noise").replace("ece", "ECE")
    help_text = f"Gate: {what} at {'most' if upper else 'least'} this share (exit 4 if missed)."
    return Annotated[float | None, typer.Option("--" + name.replace("_", "-"), min=0, max=1, help=help_text)]


def calibration_in_use(path: Path | None) -> dict[str, Any] | None:
    """Return the calibration that the diagnosis uses: the given file, or the one in the package if there is one."""
    from importlib import resources

    from sstl_cli.core.files import read_json

    schema = "sstl.blind.calibration/1"
    if path is not None:
        given: dict[str, Any] = read_json(path, schema)
        return given
    packaged = resources.files("sstl_cli.diagnosis") / "calibration.json"
    if not packaged.is_file():
        return None
    with resources.as_file(packaged) as file:
        found: dict[str, Any] = read_json(file, schema)
    return found


def missed(document: dict[str, Any], gates: dict[str, float | None]) -> list[str]:
    """Return the gates that a score misses, each as a sentence; no case at all misses a gate, too."""
    texts = []
    for name, bound in gates.items():
        if bound is None:
            continue
        score, upper = GATES[name]
        found = document["scores"][score]
        value = found["share"] if isinstance(found, dict) else found
        said = score.replace("_", " ")
        if value is None:
            texts.append(f"{said}: no case of the set bears on it")
        elif (value > bound) if upper else (value < bound):
            texts.append(f"{said} {value:.3g} is {'above' if upper else 'below'} {bound:g}")
    return texts


def score(screen: Screen, document: dict[str, Any]) -> None:
    """Print targets, scores by strength and effect, baselines, misses and wrong names."""
    from sstl_cli.blind.strength import STRENGTHS

    rows: list[tuple[object, ...]] = []
    for t in document["targets"]:
        sign = {"max": "<=", "min": ">=", "within": "+-0.05 of"}[t["rule"]]
        count = f"{t['k']}/{t['n']}" if "k" in t else ""
        spread = f"{t['low']:.2f}-{t['high']:.2f}" if "k" in t else ""
        verdict = {True: "met", False: "MISSED", None: "no case"}[t["met"]]
        rows.append((t["name"], _pct(t["value"]), count, spread, f"{sign} {t['target']:g}", verdict))
    screen.table("targets", ("score", "value", "cases", "95 %", "target", ""), rows)
    header = ("strength", "isolation", "in group", "wrong commits", "unknown recall", "pairs", "coverage")
    fields = ("isolation", "in_group", "wrong_commits", "unknown_recall", "both_of_a_pair", "coverage")
    strengths: list[tuple[object, ...]] = [
        (f"{r['strength']:g} x noise", *(_share(r[f]) for f in fields))
        for r in document["by_strength"]
        if r["strength"] is not None
    ]
    screen.table("by strength (right of all)", header, strengths)
    compared = ("isolation", "false_alarm", "wrong_commits", "unknown_recall")
    screen.table(
        "beside simple rules",
        ("rule", *(f.replace("_", " ") for f in compared)),
        [(b["name"], *(_share(b[f]) for f in compared)) for b in document["baselines"]],
    )
    screen.table(
        "isolation by effect, and why the others were likely missed",
        ("effect", *(f"{s:g}" for s in STRENGTHS), "misses"),
        [(e["effect"], *map(_share, e["isolation"].values()), e["reason"]) for e in document["by_effect"]],
    )
    misses = [v for e in document["by_effect"] for v in e["misses"]]
    if misses:
        screen.table(
            "missed single effects",
            ("case", "withheld", "strength", "verdict", "named or grouped"),
            [
                (m["case"], "+".join(m["withheld"]), m["strength"], m["status"], ", ".join(m["ambiguity_group"]))
                for m in misses[:MISSES_SHOWN]
            ],
            f"and {len(misses) - MISSES_SHOWN} more in --json" if len(misses) > MISSES_SHOWN else "",
        )
    wrong = [v for v in document["verdicts"] if v["wrong_commit"]]
    if wrong:
        screen.table(
            "wrong names",
            ("case", "kind", "withheld", "strength", "named", "confidence"),
            [
                (w["case"], w["kind"], "+".join(w["withheld"]), w["strength"], "+".join(w["effects"]), w["confidence"])
                for w in wrong[:MISSES_SHOWN]
            ],
        )
    size, off = document["group"]["mean_size"], document["shrink_mean_difference_pct"]
    if size is not None:
        screen.line(f"ambiguity set: {size:.2f} members on average")
    if off is not None:
        screen.line(f"shrinkage: predicted and realised differ by {off:.1f} percentage points on average")
    seconds = document["seconds"]
    screen.line(f"time a case: {seconds['mean']:.1f} s on average, {seconds['max']:.1f} s at most")


def real(screen: Screen, document: dict[str, Any]) -> None:
    """Print what was taken out and what was named."""
    screen.table(
        "taken out of the accepted model and diagnosed back",
        ("taken out", "from", "verdict", "named", "shrink %"),
        [
            (r["taken_out"] or "nothing", r["origin"], r["status"], ", ".join(r["ambiguity_group"]), r["shrink_pct"])
            for r in document["trials"]
        ],
    )
    screen.line(
        f"{document['named']} of {document['of']} named, {document['in_group']} in the ambiguity group, "
        f"{document['wrong']} wrong; with nothing taken out: {'an alarm' if document['false_alarm'] else 'none'}"
    )
    if document["false_alarm"]:
        screen.note(
            "the model does not explain these recordings: what it leaves is more than noise and hides its terms"
        )


def _share(found: Any) -> str:
    return "-" if found is None else f"{found['k']}/{found['n']}"


def _pct(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.1f} %"

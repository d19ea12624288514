"""What recordings could tell, by strength and effect, and which effects nothing tells apart: the tables of docs/limit.md.

    python tools/limit_table.py [--cases 150] [--seconds 600] [--rows data/limit_cases.json]

Draws short cases of one effect from all simulators, as a blind set does, and takes the distances of each from its truth; no
diagnosis is run. Resumable: what is in the file of rows is kept, and a run ends after so many seconds.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter, defaultdict
from pathlib import Path

from page_part import commit, commits, put, table

from sstl_cli.blind import sides
from sstl_cli.blind.judge import wilson
from sstl_cli.blind.schedule import jobs
from sstl_cli.blind.strength import STRENGTHS
from sstl_cli.core.documents.blind import CaseDistance
from sstl_cli.core.observer import ideal
from sstl_cli.steps import blind_limit
from sstl_cli.steps.blind_make import draw_job

ROOT = Path(__file__).resolve().parents[1]
SEED = 52_000_000
KEPT = (
    "case",
    "effects",
    "d2_base",
    "d2_rival",
    "rival",
    "d2_base_known",
    "d2_rival_known",
    "d2_own",
    "decidable",
    "decidable_known",
    "why",
)


def measured(cases: int, seconds: float, path: Path) -> list[dict]:
    """Return the rows of the single-effect cases of a set, taking those that are missing while there is time."""
    rows = json.loads(path.read_text()) if path.exists() else []
    done, end = {r["case"] for r in rows}, time.monotonic() + seconds
    for job in jobs(cases, SEED, "mixed", True):
        name = f"{job.simulator}-{job.seed}"
        if job.entry.kind != "single" or name in done:
            continue
        if time.monotonic() > end:
            print(f"stopped with {len(rows)} rows; run again to go on")
            break
        case = draw_job(job)
        found = blind_limit.run(name, case.truth, case.sim, case.exclude).plain()
        rows.append({"commit": commit(), "band": case.truth.band, "recording": case.truth.recording, **{k: found[k] for k in KEPT}})
        path.write_text(json.dumps(rows, indent=1) + "\n")
    return rows


def share(rows: list[dict], key: str) -> str:
    """Return how many of the rows could be decided."""
    if not rows:
        return "-"
    k = sum(bool(r[key]) for r in rows)
    low, high = wilson(k, len(rows))
    return f"{k} of {len(rows)} ({100 * low:.0f}-{100 * high:.0f} %)"


def by_strength(rows: list[dict]) -> str:
    """Return the table of decidable cases by strength."""
    lines = ["| gap / noise | input noise not smoothed | input known | ideal observer names |", "|---|---|---|---|"]
    for s in STRENGTHS:
        own = [r for r in rows if r["band"] == s]
        named = [ideal(d) for r in own if (d := sides.smallest(CaseDistance.model_construct(**r))) is not None]
        mean = f"{100 * sum(named) / len(named):.0f} %" if named else "-"
        lines.append(f"| {s:g} | {share(own, 'decidable')} | {share(own, 'decidable_known')} | {mean} |")
    return "\n".join(lines)


def by_effect(rows: list[dict]) -> str:
    """Return the table of smaller distances by effect and strength, and what passes for each effect."""
    lines = [
        "| effect | " + " | ".join(f"{s:g}" for s in STRENGTHS) + " | nearest rival where undecidable |",
        "|---|" + "---|" * (len(STRENGTHS) + 1),
    ]
    for effect in sorted({e for r in rows for e in r["effects"]}):
        own = [r for r in rows if r["effects"] == [effect]]
        cells = []
        for s in STRENGTHS:
            found = [sides.smallest(CaseDistance.model_construct(**r)) for r in own if r["band"] == s]
            cells.append(", ".join(f"{d:.3g}" for d in found if d is not None) or "-")
        near = Counter(r["rival"] for r in own if not r["decidable"] and r["rival"])
        lines.append(f"| `{effect}` | " + " | ".join(cells) + f" | {', '.join(f'{n} {k}x' for n, k in near.most_common(3)) or '-'} |")
    return "\n".join(lines)


def never(rows: list[dict]) -> str:
    """Return the pairs that stay below D^2 of 6 at four times the noise, with the recordings on which they do."""
    pairs = defaultdict(list)
    for r in rows:
        if r["band"] == STRENGTHS[-1] and r["d2_rival"] is not None and r["d2_rival"] < 6.0:
            pairs[f"`{r['effects'][0]}` for `{r['rival']}`"].append(r["recording"] or "complete, two bends")
    return "\n".join(f"- {k}: {'; '.join(v)}" for k, v in sorted(pairs.items())) or "None."


def shares(rows: list[dict]) -> str:
    """Return what stands in docs/limit.md of short recordings: decidable cases by strength and effect, and pairs that nothing separates."""
    return (
        f"{len(rows)} cases of one effect, three simulators, half of them recorded as labs do; commit {commits(rows)}.\n\n{by_strength(rows)}\n\n"
        f"Smaller of the distances to base and nearest rival, case by case:\n\n{by_effect(rows)}\n\n"
        f"At four times the noise these stay below D^2 = 6: no likelihood of the fast model tells them apart on these recordings:\n\n{never(rows)}"
    )


def simulated(path: Path) -> str:
    """Return the table of predicted and simulated error rates, and how many agree."""
    rows = json.loads(path.read_text())
    # rows from before it was worked out have no prediction of what is free
    free = all("agrees_free" in r for r in rows)
    agree, agree_free, between = (sum(r.get(key, False) for r in rows) for key in ("agrees", "agrees_free", "between"))
    refitted = f" ({agree_free} where all that is refitted is counted)" if free else ""
    head = [
        "effect, rival", "D^2, input known", "predicted error", *(["all refitted"] if free else []), "simulated", "D^2, not smoothed",
        "predicted error", "simulated, full recordings",
    ]  # fmt: skip
    lines = [
        [
            f"`{r['effect']}`, `{r['rival']}`", f"{r['d2_known']:.1f}", _pct(r, "predicted_known"),
            *([_pct(r, "predicted_free")] if free else []), _pct(r, "simulated_known", "low", "high"),
            f"{r['d2']:.1f}", _pct(r, "predicted"), _pct(r, "simulated_full", "full_low", "full_high"),
        ]
        for r in rows
    ]  # fmt: skip
    return (
        f"Commit {commits(rows)}: {agree} of {len(rows)} agree within their intervals with the input known{refitted}, {between} of {len(rows)} "
        f"full recordings lie between the two predictions; all were asked.\n\n{table(head, lines)}"
    )


def _pct(r: dict, *keys: str) -> str:
    """Return a share in percent, with its interval where that is asked for."""
    value, *ends = (f"{100 * r[k]:.0f}" for k in keys)
    return f"{value} %" + (f" ({'-'.join(ends)} %)" if ends else "")


def main() -> None:
    """Take the distances that are missing and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=150)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--rows", type=Path, default=ROOT / "data" / "limit_cases.json")
    parser.add_argument("--simulation", type=Path, default=ROOT / "data" / "limit_simulation.json")
    given = parser.parse_args()
    rows = measured(given.cases, given.seconds, given.rows)
    put("limit.md", "shares", shares(rows))
    if given.simulation.exists():
        put("limit.md", "simulated", simulated(given.simulation))


if __name__ == "__main__":
    main()

"""Measure by simulation whether the printed intervals and probabilities hold; writes docs/statistics.md.

``python tools/statistics_table.py [--loops 1000] [--cases 30] [--minutes 20] [--seed 1]``: ``loops`` recordings a row for
Theta, up to ``cases`` recordings for each of six effects, by rig and fast model, and four times as many of a rig without any,
until the minutes are over; ``--cases 0`` leaves the diagnosis out.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from page_part import DOCS, commit, table
from scipy import stats
from statistics_cases import PARAMETERS, RIVAL, STRENGTH, case, loops

from sstl_cli.blind import accepted
from sstl_cli.blind.judge import wilson
from sstl_cli.core.documents.diagnosis import Interval
from sstl_cli.core.errors import SstlError
from sstl_cli.core.files import write_text
from sstl_cli.identification import segment_run
from sstl_cli.identification.change import Chart
from sstl_cli.physics.effects import get
from sstl_cli.steps import diagnose

LOW, HIGH = 0.93, 0.97
SIMULATORS = {"transmission": "fast model", "rig": "rig"}
Counts = dict[str, list[bool]]


def row(name: str, data: str, hits: list[bool]) -> list[object]:
    """Return a row: share of hits with its own Wilson interval, and whether it is where it should be."""
    n, k = len(hits), sum(hits)
    if not n:
        return [name, data, 0, "-", "-", "no case"]
    low, high = wilson(k, n)
    inside = LOW <= k / n <= HIGH
    said = "yes" if inside else ("no, but not beyond chance" if low <= HIGH and high >= LOW else "**no**")
    return [name, data, n, f"{100 * k / n:.1f} %", f"{100 * low:.1f}-{100 * high:.1f} %", said]


def of_theta(count: int, seed: int) -> list[list[object]]:
    """Return the coverage of estimate +- 1.96 standard errors from ``segment``."""
    rows = []
    for colour in (False, True):
        hits: dict[str, list[bool]] = defaultdict(list)
        for lines, run in loops(count, colour, seed):
            found = segment_run(run)
            for name, true in zip(PARAMETERS, lines, strict=True):
                value, se = found.theta[name], found.theta_se[name]
                if value is not None and se is not None:
                    hits[name].append(abs(value - true) <= 1.96 * se)
        data = f"play operator, {'coloured (0.3 s)' if colour else 'white'} noise"
        rows += [row(f"Theta, {name}", data, hits[name]) for name in PARAMETERS]
    return rows


def of_wilson(seed: int) -> list[list[object]]:
    """Return the coverage of the Wilson interval for shares from 0.5 to 0.99."""
    rng = np.random.default_rng(seed)
    rows = []
    for n in (30, 150, 1500):
        p = rng.uniform(0.5, 0.99, 20_000)
        hits = [low <= q <= high for q, k in zip(p, rng.binomial(n, p), strict=True) for low, high in [wilson(int(k), n)]]
        rows.append(row("Wilson", f"binomial, n = {n}", hits))
    return rows


def within(value: float, interval: Interval) -> bool:
    """Return whether a value lies in an interval, whose ends may be open."""
    low, high = interval
    return (low is None or low <= value) and (high is None or value <= high)


def of_diagnosis(cases: int, seed: int, end: float) -> tuple[list[list[object]], list[list[object]]]:
    """Return the coverage of parameters and shrinkage, and how often nothing is found where nothing is."""
    covered: dict[tuple[str, str], Counts] = {(s, e): defaultdict(list) for s in SIMULATORS for e in STRENGTH}
    alarms: list[bool] = []
    right: list[bool] = []
    stated: list[float] = []
    bound = 0
    for number in range(cases):
        for simulator, effect in [*covered, *[("rig", None)] * 4]:
            if time.monotonic() > end:
                break
            drawn = case(effect, len(alarms) if effect is None else number, seed, simulator)  # type: ignore[arg-type]
            counts = covered.get((simulator, effect or ""), defaultdict(list))
            rival = [effect, RIVAL[effect]] if effect else ["const_friction", "viscous", "channel_delay"]
            options = diagnose.DiagnoseOptions(sim=drawn.nominal(), effects=tuple(rival), max_effects=1)
            try:
                result = diagnose.run(drawn.record(), options)
            except SstlError as error:
                print(f"{effect} {number}: {error.line()}", file=sys.stderr)
                continue
            verdict, gap, analysis = result.body.verdict, result.body.gap, result.body.analysis
            # the odds are those of the library, and all was analysed
            assert verdict.confidence is not None and analysis is not None
            stated.append(verdict.confidence)
            if effect is None:
                alarms.append(verdict.status != "none")
                right.append(not alarms[-1])
                continue
            right.append(effect in verdict.ambiguity_group)
            if verdict.effects != [effect]:
                counts["missed"].append(True)
                continue
            found = next(c for c in result.body.candidates if c.id == effect)
            # the line's compliance, fitted along, is no strength of the effect
            own = [p for p in found.parameters if p.effect == effect]
            bound += sum(p.at_bound for p in own)
            # what was not stated does nothing
            truth = {p.name: p.neutral for p in get(effect).parameters} | drawn.effects[effect]
            counts["parameters"] += [within(truth[p.name], p.ci95) for p in own if not p.at_bound and p.ci95 is not None]
            base = accepted.retuned(drawn.nominal(), analysis.theta)
            true = accepted.realised_shrink_pct(base, result.model(), drawn.record(1) + again(drawn.record(2)))
            if gap.shrink_ci95_pct is not None:
                counts["shrinkage"].append(true is not None and within(true, gap.shrink_ci95_pct))
            print(f"{number} {simulator} {effect}: { {k: (sum(v), len(v)) for k, v in counts.items()} }", file=sys.stderr, flush=True)
    rows: list[list[object]] = []
    for what in ("parameters", "shrinkage"):
        for simulator, said in SIMULATORS.items():
            rows += [row(f"diagnose, {what}", f"{said} with {e}", covered[simulator, e][what]) for e in STRENGTH]
            every = [h for e in STRENGTH for h in covered[simulator, e][what]]
            rows.append(row(f"diagnose, {what}", f"{said}, all of these", every))
    missed = {f"{s}/{e}": len(c["missed"]) for (s, e), c in covered.items() if c["missed"]}
    low, high = wilson(sum(alarms), len(alarms))
    null = [
        ["an effect is named, or a gap called unknown, where the rig has none", len(alarms), f"{sum(alarms)} of {len(alarms)}", f"at most 5 % (95 % interval {100 * low:.1f}-{100 * high:.1f} %)"],
        ["stated confidence against share of right verdicts, all cases", len(right), f"{np.mean(stated):.3f} stated, {np.mean(right):.3f} right", "equal"],
        ["verdict names another effect or none (left out above)", len(right), str(missed or 0), "-"],
        ["parameters at the end of their range (left out above)", sum(len(c["parameters"]) for c in covered.values()) + bound, str(bound), "-"],
    ]  # fmt: skip
    return rows, null


def again(runs: list[Any]) -> list[Any]:
    """Return runs under names of their own, so that two recordings can be judged as one."""
    from dataclasses import replace

    return [replace(r, run_id=f"{r.run_id}-again") for r in runs]


def of_p_values(seed: int, draws: int = 4000) -> list[list[object]]:
    """Return how the p values of ``evaluate`` fall where two variants are equally good (20 seeds)."""
    from sstl_cli.mapping.evaluation import Score, compare

    rng = np.random.default_rng(seed)
    p_t, p_w, family = [], [], []
    for _ in range(draws):
        common = rng.normal(1.0, 0.1, 20)
        scores = []
        for name in "abcd":
            rmse = np.repeat((common + rng.normal(0.0, 0.05, 20))[:, None], 3, axis=1)
            scores.append(Score(name, name, rmse, np.zeros(3), np.zeros(3)))
        found = compare(scores)
        p_t.append(found[0].p_t)
        p_w.append(found[0].p_wilcoxon)
        family.append(min(c.p_holm for c in found) < 0.05)
    rows = []
    for name, p in (("paired t", np.array(p_t)), ("Wilcoxon signed rank", np.array(p_w))):
        uniform = stats.kstest(p, "uniform").statistic
        rows.append(
            [
                f"p of the {name} test below 0.05",
                draws,
                f"{100 * np.mean(p < 0.05):.1f} % (largest distance from uniform {uniform:.3f})",
                "5 %",
            ]
        )
    rows.append(["any of six p values after Holm below 0.05", draws, f"{100 * np.mean(family):.1f} %", "at most 5 %"])
    return rows


def of_watch(seed: int, repetitions: int = 400) -> list[list[object]]:
    """Return how often ``watch`` alarms within the stated number of loops where nothing changes."""
    rows = []
    for phi in (0.0, 0.5):
        rng = np.random.default_rng([seed, int(10 * phi)])
        hits = []
        for _ in range(repetitions):
            chart, v, hit = Chart((0, 0, 0, 0, 1), 20, 100.0), rng.standard_normal(5), False
            for k in range(120):
                v = phi * v + np.sqrt(1 - phi**2) * rng.standard_normal(5)
                hit = hit or chart.add(v) is not None
                if k == 119 or hit:
                    break
            hits.append(hit)
        rows.append(
            [
                f"watch alarms within 100 loops, lag-one correlation {phi:g}",
                repetitions,
                f"{100 * np.mean(hits):.1f} %",
                "at most 63 % (one alarm in 100 loops)",
            ]
        )
    return rows


def main() -> int:
    """Measure and write; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--loops", type=int, default=1000)
    parser.add_argument("--cases", type=int, default=30)
    parser.add_argument("--minutes", type=float, default=22.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=DOCS / "statistics.md")
    given = parser.parse_args()
    end = time.monotonic() + 60 * given.minutes
    coverage = of_theta(given.loops, given.seed) + of_wilson(given.seed)
    others = of_p_values(given.seed) + of_watch(given.seed)
    of_effects, null = of_diagnosis(given.cases, given.seed, end) if given.cases else ([], [])
    text = PAGE.format(
        commit=commit(),
        diagnosed=DIAGNOSED if given.cases else UNDIAGNOSED,
        words=f"--loops {given.loops} --cases {given.cases} --minutes {given.minutes:g} --seed {given.seed}",
        coverage=table(["interval", "data", "intervals", "hold the truth", "95 % interval of that", "93-97 %"], coverage + of_effects),
        null=table(["where nothing is to be found", "cases", "measured", "should be"], null + others),
    )
    write_text(given.out, text, force=True)
    return 0


PAGE = """# Do the printed intervals hold?

Every interval that the program prints is meant to hold the truth 95 times in 100. Here is how often it does, on data from other
code than the one that is judged: a play operator in plain Python for Theta. Written by `make statistics`
(`tools/statistics_table.py {words}`), of commit {commit}.

{coverage}

{diagnosed}

{null}
"""
DIAGNOSED = """The diagnosis is shown recordings of the elastic rig and of the fast model that it fits: there only chance can make an interval miss, on the
rig what the two models do differently as well, and that is no part of the interval. The half width of a parameter's interval is 1.96 times the
larger of what the noise gives and the sandwich error over blocks of time. A parameter's truth is what the simulator was given, that of a
shrinkage what the accepted simulator does to fresh recordings of the same simulator. Intervals of one recording are not
independent, so that the interval of a share is somewhat too narrow where a recording gives several."""
UNDIAGNOSED = """Intervals of the diagnosis (parameters, shrinkage) were not measured with this version. The rows that stood here were of 21 November 2026,
before likelihood, search and verdict were rebuilt, and say nothing of what is there now. `make statistics` measures them (hours). The
half width of a parameter's interval is 1.96 times the larger of what the noise gives and the sandwich error over blocks of time
(`diagnosis/shrink.py`); how far predicted and realised shrinkage differ on a sealed set stands in [blind.md](blind.md)."""

if __name__ == "__main__":
    sys.exit(main())

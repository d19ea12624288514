"""From what was rebuilt to what is shown: tables of text, sentences and figures."""

from __future__ import annotations

import numpy as np

from sstl_cli.identification import PHASE_NAMES
from sstl_cli.paper import figures
from sstl_cli.paper.figures import Drawing, Loop, Tracked
from sstl_cli.paper.grid import Grid, entry_grids, number, tracking_grids
from sstl_cli.paper.published import value
from sstl_cli.steps.reproduce import Reproduction
from sstl_cli.steps.reproduce_better import ALL_MEANS, TARGETS_N
from sstl_cli.steps.reproduce_probe import FULL, PARTIAL, shortest


def grids(found: Reproduction) -> list[Grid]:
    """Return every table that was asked for."""
    return [
        *entry_grids(found.compared),
        *_mapping(found),
        *tracking_grids(found.compared),
        *_gap(found),
        *_named(found),
        *_better(found),
        *_probe(found),
    ]


def facts(found: Reproduction) -> list[str]:
    """Return the sentences that sum up what the tables show."""
    said = []
    if found.spread.seeds:
        said.append(
            f"Verdicts: the published value against mean and 2 sd of ours over {found.spread.seeds} data sets "
            "(Table III: over training seeds)."
        )
    m = found.mapping
    if m is not None:
        best = m.entries["III", m.best, "total"]
        linear = m.entries["III", "linear", "total"]
        said.append(
            f"Table III: linear {linear:.4f} (paper 0.0193), best variant {m.best} {best:.4f} (paper 0.0166), "
            f"Bayes-optimal predictor {m.limit.total:.4f} ({m.limit_here.total:.4f} on these 150): "
            f"{100 * (best / m.limit.total - 1):.0f} % above the limit."
        )
    if found.gap is not None:
        g = found.gap
        said.append(
            f"Table IV: distance to the paper (rms over every RMSE and STD) {g.stated:.2f} N as stated, "
            f"{g.explained:.2f} N as explained: {g.shrink_pct:.0f} % of the difference explained."
        )
    if found.better:
        rung = next(r for r in found.better if r.name == ALL_MEANS)
        said.append(
            "Better than the paper, without distal sensor: "
            + ", ".join(f"{t} {rung.mean(t):.2f} N (target {limit:.2f})" for t, limit in TARGETS_N.items())
            + "."
        )
    if found.probes:
        a, b = shortest(found.probes, "lines_error"), shortest(found.probes, "tracking_n")
        said.append(
            f"Shortest probe within 10 % of 12 s: {a.time_s:.1f} s by Theta ({a.kind}), "
            f"{b.time_s:.1f} s by tracking ({b.kind})."
        )
    return said


def _mapping(found: Reproduction) -> list[Grid]:
    m = found.mapping
    if m is None or not any(c.entry.table == "III" for c in found.compared):
        return []
    tests = tuple(
        (f"{t.first} - {t.second}", f"{t.difference:+.5f}", f"{t.p_corrected:.2g}", f"{t.p_wilcoxon:.2g}")
        for t in m.tests
    )
    places = tuple(m.left_out)
    names = list(next(iter(m.left_out.values())))
    away = tuple((n, *(f"{m.left_out[p][n].total:.4f}" for p in places)) for n in names)
    low_high = ", ".join(
        f"{s} {m.entries['range', f'act_gamma_{d}', 'low']:.2f}-{m.entries['range', f'act_gamma_{d}', 'high']:.2f} "
        f"(paper {value('range', f'act_gamma_{d}', 'low'):.2f}-{value('range', f'act_gamma_{d}', 'high'):.2f})"
        for s, d in (("Gp", "p"), ("Gr", "r"))
    )
    return [
        Grid(
            "III-tests",
            "Table III: paired differences of Total over seeds",
            ("variants", "mean difference", "p corrected", "p signed rank"),
            tests,
            (
                "corrected: t test with the variance raised for overlapping test sets. Each seed has its own held-out "
                f"part, so its sd holds both. Range of the true slopes: {low_high}.",
            ),
        ),
        Grid(
            "III-left-out",
            "Table III: Total at a location that training never saw",
            ("variant", *places),
            away,
            ("'ideal of the others' knows the generator at the other two locations, and nothing of this one.",),
        ),
    ]


def _gap(found: Reproduction) -> list[Grid]:
    g = found.gap
    if g is None:
        return []
    rows = tuple((s.part, f"{s.alone:.2f}", f"{s.without:.2f}", f"{s.share_pct:.0f}") for s in g.shares)
    return [
        Grid(
            "IV-gap",
            f"Table IV: what explains the difference ({g.stated:.2f} N as stated, {g.explained:.2f} N with all)",
            ("part", "N with it alone", "N with all but it", "share %"),
            rows,
            ("distance: rms of ours - paper over every RMSE and STD; shares by Shapley's rule.",),
        )
    ]


def _named(found: Reproduction) -> list[Grid]:
    n = found.named
    if n is None:
        return []
    rows = tuple((x.effects, f"{x.rmse_n:.2f}", f"{x.shrink_pct:.0f}") for x in n.leading)
    notes = [f"before: {n.retuned_n:.2f} N re-tuned, noise floor {n.floor_n:.2f} N; {n.sentence}"]
    if n.beside:
        notes.append(f"beside the output tension, in how the input follows its reference: {n.beside}")
    return [
        Grid(
            "IV-diagnosis",
            "Table IV: which effect, added to the stated simulator, would make it meet the explained recordings",
            ("effect", "N left", "shrink %"),
            rows,
            tuple(notes),
        )
    ]


def _better(found: Reproduction) -> list[Grid]:
    if not found.better:
        return []
    rows = tuple(
        (r.name, *(number(v, 2) for t in ("sinusoid", "random") for v in (*r.rmse_n[t], r.mean(t))))
        for r in found.better
    )
    return [
        Grid(
            "better",
            "The rig with the paper's gap: RMSE (N) at NP, CP, ND and mean; sinusoid, then random",
            ("means", *("NP", "CP", "ND", "mean") * 2),
            rows,
            ("Paper's direct identification: 0.45 and 0.86 N. One held-out bend a location; without the first cycle.",),
        )
    ]


def _probe(found: Reproduction) -> list[Grid]:
    if not found.probes:
        return []
    rows = tuple(
        (
            p.kind,
            number(p.time_s, 1),
            number(p.top_n, 0),
            number(100 * p.lines_error, 2),
            number(None if p.segmented_error is None else 100 * p.segmented_error, 2),
            number(p.tracking_n, 3),
        )
        for p in found.probes
    )
    return [
        Grid(
            "probe",
            "A shorter probe",
            ("probe", "s", "top N", "slopes %, fit", "slopes %, segm.", "RMSE N"),
            rows,
            (
                "fit: one theta fitted to the whole recording; segm.: segmentation and linear map, "
                "'-' where a bend shows no release line.",
            ),
        )
    ]


def drawings(found: Reproduction) -> list[Drawing]:
    """Return the figures that what was rebuilt allows."""
    done: list[Drawing] = []
    if found.slopes is not None:
        shown = {s.run.system: _loop(s) for s in found.slopes.shown}
        done += [figures.loop(shown["act"]), figures.segmentation([shown["act"], shown["sstl"]])]
        rows = found.slopes.theta.to_pylist()
        lead = {s: np.array([r["lead_mm"] for r in rows if r["system"] == s]) for s in ("act", "sstl")}
        columns = {
            s: {
                p: np.array([r[p] if r[p] is not None else np.nan for r in rows if r["system"] == s])
                for p in ("gamma_p", "gamma_r", "beta_p", "beta_r")
            }
            for s in ("act", "sstl")
        }
        both = {s: np.column_stack([columns[s]["gamma_p"], columns[s]["gamma_r"]]) for s in columns}
        done += [
            figures.correlation(both["act"], both["sstl"]),
            figures.product(lead["act"], both["act"], both["sstl"]),
            figures.parameters(lead, columns),
        ]
    if found.blocks:
        explained = found.blocks[-1]
        runs = []
        for name in ("sinusoid", "random"):
            own = [r for r in explained.results if r.trajectory == name and r.case.location == "CP"]
            outputs = {r.method: r.track.tension_out for r in own if r.method != "no-bias"}
            runs.append(Tracked(name, own[0].reference.time_s, own[0].reference.tension_n, outputs))
        done.append(figures.tracking(runs, f"Tracking at CP under both references ({explained.settings.title})."))
    if found.mapping is not None:
        done.append(figures.ablation(found.mapping.per_seed, found.mapping.limit.total))
    if found.better:
        first = [r for r in found.better if not r.name.startswith(("no comp", "all means"))]
        values = {t: [r.mean(t) for r in first] for t in TARGETS_N}
        done.append(figures.ladder([r.name for r in first], values, TARGETS_N))
    if found.probes:
        curves = {}
        for kind in (FULL, PARTIAL):
            own_probes = [p for p in found.probes if p.kind == kind or p is found.probes[0]]
            time, lines, error = np.array([(p.time_s, p.lines_error, p.tracking_n) for p in own_probes]).T
            curves[kind] = (time, lines, error)
        done.append(figures.probe(curves))
    return done


def _loop(one: object) -> Loop:
    run, found = one.run, one.segmentation  # type: ignore[attr-defined]
    return Loop(run.system, run.tension_in_n, run.tension_out_n, found.phases, PHASE_NAMES, found.theta)

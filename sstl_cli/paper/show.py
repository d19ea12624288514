"""From what was rebuilt to what is said: tables of text and sentences."""

from __future__ import annotations

from sstl_cli.paper import contests, show_beyond
from sstl_cli.paper.compare import count_apart
from sstl_cli.paper.diagnosed import Closed
from sstl_cli.paper.grid import NAMES, SOURCES, Grid, count_grid, entry_grids, number, tracking_grids
from sstl_cli.paper.published import of_table, value
from sstl_cli.paper.reproduce import Reproduction
from sstl_cli.paper.settings import fitted_values
from sstl_cli.paper.spread import Spread, of_draws, stored
from sstl_cli.paper.table_iii import BEST


def grids(found: Reproduction) -> list[Grid]:
    """Return every table that was asked for."""
    counts = count_apart(found.compared)
    return [
        *entry_grids(found.compared),
        *_mapping(found),
        *tracking_grids(found.compared),
        *_whole(found),
        *_gap(found),
        *entry_grids(found.compared, "rig"),
        *_closed(found.closed),
        *show_beyond.grids(found),
        *([count_grid(counts)] if counts else []),
    ]


def facts(found: Reproduction) -> list[str]:
    """Return the sentences that sum up what the tables show."""
    said = []
    if found.compared:
        seeds = {name: stored(name).seeds for name in ("generator", "III", "R")}
        said.append(
            f"Verdicts: the published value against mean and 2 sd of ours over data sets ({seeds['generator']} of the "
            f"generator, {seeds['III']} for Table III, {seeds['R']} for block R)."
        )
    m = found.mapping
    if m is not None and any(c.entry.table == "III" for c in found.compared):
        said += _mapping_facts(found)
    if found.gap is not None:
        g = found.gap
        said.append(
            f"Table IV: distance to the paper (rms over every RMSE and STD) {g.stated:.2f} N as stated, "
            f"{g.fitted:.2f} N under 14 fitted numbers: {g.shrink_pct:.0f} % of the difference fitted."
        )
    said += [*_rig_facts(found), *_floor_facts(found)]
    said += show_beyond.facts(found)
    return said


def _mapping_facts(found: Reproduction) -> list[str]:
    m = found.mapping
    assert m is not None
    best, linear = m.entries["III", m.best, "total"], m.entries["III", "linear", "total"]
    said = [
        f"Table III, this data set: linear {linear:.4f} (paper {value('III', 'linear', 'total'):.4f}), best variant {m.best} {best:.4f} "
        f"(paper {value('III', BEST, 'total'):.4f}), Bayes-optimal predictor {m.limit.total:.4f} ({m.limit_here.total:.4f} on these 150)."
    ]
    spread = stored("III")
    held = contests.contests(spread)
    beyond = [c for c in held if c.verdict]
    if held:
        named = "; ".join(
            f"{NAMES[c.first]} against {NAMES[c.second]} {c.difference:+.4f}, lower on {100 * c.wins:.0f} % of them" for c in beyond
        )
        said.append(
            f"Over {spread.seeds} data sets: "
            + (f"beyond chance (Holm, 5 %) are {named}." if beyond else "no variant differs beyond chance (Holm, 5 %).")
        )
    return said


def _rig_facts(found: Reproduction) -> list[str]:
    if not found.rig:
        return []
    mean = of_draws([d.entries for d in found.rig])
    steady, whole = mean.of("rig"), mean.of("rig, whole")
    red, recovery = (("headline", "proposed", c) for c in ("red", "recovery"))
    n = len(found.rig)
    checked = sum(len(m) for m in mean.blocks.values())
    verdict = (
        f"{len(found.outside)} of {checked} entries lie outside the committed spread"
        if found.outside
        else f"All {checked} entries lie within the committed spread over {stored('R').seeds} data seeds"
    )
    published = " and ".join(f"{value(*k):.1f}" for k in (red, recovery))
    return [
        f"Block R, mean of {n} data seeds: reduction {steady[red][0]:.1f} % and {steady[recovery][0]:.1f} % of direct "
        f"identification's ({whole[red][0]:.1f} and {whole[recovery][0]:.1f} with the first cycle; paper {published}). {verdict}."
    ]


def _floor_facts(found: Reproduction) -> list[str]:
    """Return which samples MAPE leaves out, over everything that was tracked."""
    scores = [s for d in found.rig if d.tracked is not None for cells in d.tracked.scores.values() for s in cells.values()]
    scores += [s for b in found.blocks for r in b.results for s in r.scores.values()]
    if not scores:
        return []
    most = max(s.masked_pct for s in scores)
    below = "no sample lies below it" if most == 0.0 else f"up to {most:.2g} % of the samples lie below it and are left out"
    return [f"MAPE has a floor of {scores[0].mape_floor_n:g} N on the reference: {below}."]


def _mapping(found: Reproduction) -> list[Grid]:
    m = found.mapping
    if m is None or not any(c.entry.table == "III" for c in found.compared):
        return []
    places = tuple(m.left_out)
    names = list(next(iter(m.left_out.values())))
    away = tuple((n, *(f"{m.left_out[p][n].total:.4f}" for p in places)) for n in names)
    return [
        *_spreads(found, stored("III")),
        *_contests(stored("III")),
        Grid(
            "III-left-out",
            "Table III: Total at a location that training never saw",
            ("variant", *places),
            away,
            ("'ideal of the others' knows the generator at the other two locations, and nothing of this one.",),
            source=SOURCES["stated"],
        ),
    ]


def _spreads(found: Reproduction, spread: Spread) -> list[Grid]:
    """Return the three spreads of Table III apart: over data sets, over training seeds, over samples."""
    m = found.mapping
    mean, seeds, samples = (spread.of(b) for b in (contests.MEAN, contests.SEEDS, contests.SAMPLES))
    if m is None or not mean:
        return []
    rows = []
    for e in of_table("III"):
        key = (e.table, e.row, e.column)
        over_samples = f"{samples[key][0]:.3f}" if key in samples else "-"
        paper = f"{e.spread:.3f}" if e.spread is not None else "-"
        rows.append(
            (NAMES[e.row], NAMES[e.column], e.text(), f"{mean[key][0]:.4f}", f"{mean[key][1]:.4f}",
             f"{seeds[key][0]:.4f}", over_samples, paper)
        )  # fmt: skip
    low_high = ", ".join(
        f"{s} {m.entries['range', f'act_gamma_{d}', 'low']:.2f}-{m.entries['range', f'act_gamma_{d}', 'high']:.2f} "
        f"(paper {value('range', f'act_gamma_{d}', 'low'):.2f}-{value('range', f'act_gamma_{d}', 'high'):.2f})"
        for s, d in (("Gp", "p"), ("Gr", "r"))
    )
    header = ("variant", "entry", "paper", "ours", "sd data sets", "sd seeds", "sd samples", "paper +-")
    note = (
        f"ours: mean over {spread.seeds} data sets; sd seeds: over training seeds of one data set; sd samples: of the "
        "absolute errors over held-out samples, which is what the paper's +- is. Division 75:25 by configuration; a "
        f"fifth of the 75 % stops the training (the paper names no validation part). Range of the true slopes: {low_high}."
    )
    return [Grid("III-spreads", "Table III: three spreads apart", header, tuple(rows), (note,), 2, SOURCES["stated"])]


def _contests(spread: Spread) -> list[Grid]:
    rows = tuple(
        (f"{NAMES[c.first]} - {NAMES[c.second]}", f"{c.difference:+.5f}", f"{c.sd:.5f}", f"{100 * c.wins:.0f}",
         f"{c.p:.2g}", f"{c.p_holm:.2g}")
        for c in contests.contests(spread)
    )  # fmt: skip
    if not rows:
        return []
    header = ("variants", "mean difference", "sd", "lower on %", "p", "p Holm")
    note = f"paired t test over {spread.seeds} independent data sets, corrected for {len(rows)} contests by Holm's rule."
    return [Grid("III-tests", "Table III: differences of Total over data sets", header, rows, (note,), source=SOURCES["stated"])]


def _gap(found: Reproduction) -> list[Grid]:
    g = found.gap
    if g is None:
        return []
    rows = tuple((s.part, f"{s.alone:.2f}", f"{s.without:.2f}", f"{s.share_pct:.0f}") for s in g.shares)
    fitted = ", ".join(f"{name} {number:g}" for name, number in fitted_values())
    return [
        Grid(
            "IV-gap",
            f"Table IV: parts of the fit ({g.stated:.2f} N as stated, {g.fitted:.2f} N with all)",
            ("part", "N with it alone", "N with all but it", "share %"),
            rows,
            ("distance: rms of ours - paper over every RMSE and STD; shares by Shapley's rule.", f"The 14 fitted numbers: {fitted}."),
        )
    ]


def _whole(found: Reproduction) -> list[Grid]:
    """Return block R with both evaluation windows: means over the locations."""
    if not found.rig:
        return []
    steady, whole = (stored("R").of(b) for b in ("rig", "rig, whole"))
    rows = []
    for e in (*of_table("summary"), *of_table("headline")):
        key = (e.table, e.row, e.column)
        if key in steady and key in whole:
            cells = [f"{v[key][0]:.{e.decimals}f} +-{v[key][1]:.{e.decimals}f}" for v in (steady, whole)]
            rows.append((e.row, NAMES.get(e.column, e.column), e.text(), *cells))
    note = f"mean +- sd over {stored('R').seeds} data seeds; the paper does not say which window it scores."
    header = ("row", "entry", "paper", "without first cycle", "whole")
    return [Grid("R-windows", "Block R: both evaluation windows", header, tuple(rows), (note,), 2)] if rows else []


def _closed(closed: tuple[Closed, ...]) -> list[Grid]:
    """Return the simulators before and after their diagnosis, two rows each: as given, and with what was put in."""
    if not closed:
        return []
    rows: list[tuple[str, ...]] = []
    for c in closed:
        first, later = zip(c.withheld_n, c.promised_n, c.tracked_n, strict=True)
        put_in = c.named or c.tried
        rows.append((" + ".join(c.missing), "as given", "", *(number(v, 3) for v in first)))
        if put_in:
            rows.append(("", f"+ {' + '.join(put_in)}", "yes" if c.named else "no", *(number(v, 3) for v in later)))
    notes = (
        "withheld: RMSE (N) on bends the diagnosis has not seen; promised: distance (N) of the simulator's Table IV to "
        "the rig's; tracked: RMSE (N) on the rig with the mapping trained in the simulator, mean of all.",
        "named no: the diagnosis names nothing for sure; the most probable candidate is put in on trial.",
        *(f"{' + '.join(c.missing)} ({'right' if c.right else 'not right'}): {c.sentence}" for c in closed),
    )
    header = ("missing", "simulator", "named", "withheld", "promised", "tracked")
    return [Grid("gap", "The rig against a simulator that lacks something, diagnosed", header, tuple(rows), notes, 3)]

"""What is printed and drawn, from hand-made results."""

import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from sstl_cli.control.loop_lag import LoopLag
from sstl_cli.control.references import Reference
from sstl_cli.control.scoring import score
from sstl_cli.core.documents.outputs import ReproduceDocument
from sstl_cli.paper import distal, drawings, figures, show, tendons
from sstl_cli.paper import written as files
from sstl_cli.paper.bench import ModelBench
from sstl_cli.paper.better import WAYS, Calibration, Rung
from sstl_cli.paper.block_r import Tracked
from sstl_cli.paper.compare import compare
from sstl_cli.paper.data_seeds import Drawn
from sstl_cli.paper.diagnosed import UNNAMED, Closed
from sstl_cli.paper.distal import Bent
from sstl_cli.paper.gate import Outside
from sstl_cli.paper.grid import mark, text, wrapped
from sstl_cli.paper.lag_and_presliding import Fitted
from sstl_cli.paper.latex import document
from sstl_cli.paper.page import page
from sstl_cli.paper.probe import PLANS, SETTINGS, Probe
from sstl_cli.paper.published import TABLES, of_table
from sstl_cli.paper.reproduce import Reproduction
from sstl_cli.paper.settings import LOCATIONS, METHODS, TRAJECTORIES
from sstl_cli.paper.spread import stored
from sstl_cli.paper.table_iv_gap import Gap, Share
from sstl_cli.paper.tendons import Together
from sstl_cli.physics.scenario import Scenario
from sstl_cli.reporting.drawing import picture


def judged(block, spread):
    ours = {k: m for k, (m, _) in spread.of(block).items()}
    return [c for c in compare([e for t in TABLES for e in of_table(t)], ours, spread.of(block), block) if c.ours]


@pytest.fixture(scope="module")
def found():
    compared = [c for b, e in (("stated", "generator"), ("fitted", "generator"), ("rig", "R")) for c in judged(b, stored(e))]
    entries = {b: {k: m for k, (m, _) in stored("R").of(b).items()} for b in ("rig", "rig, whole")}
    time = np.arange(2000) * 0.1
    reference = 10.0 + 5.0 * np.sin(2 * np.pi * 0.01 * time)
    made = Tracked(
        {},
        {(t, m, p): reference + i for t in TRAJECTORIES for i, m in enumerate(METHODS) for p in LOCATIONS},
        {(t, p): Reference(t, time, reference, 100.0) for t in TRAJECTORIES for p in LOCATIONS},
        {(t, p): np.ones(2000, np.int8) for t in TRAJECTORIES for p in LOCATIONS},
    )
    closed = (
        Closed(("presliding", "stribeck"), "identified", ("presliding",), 0.8, "It is presliding.", (0.24, 0.09), (0.5, 0.2), (0.7, 0.6)),
        Closed((UNNAMED,), "unknown", (), None, "Not known.", (0.3, 0.3), (0.5, None), (0.6, None)),
        Closed(("stribeck",), "unknown", (), 0.6, "Not known.", (0.24, 0.1214), (0.28, 0.2), (0.8, 0.7), ("presliding", "slack")),
    )
    gap = Gap(0.9, 0.4, (Share("lines", 0.7, 0.6, 100.0),))
    return Reproduction(tuple(compared), gap=gap, rig=(Drawn(1, entries, made),), closed=closed, figures=True)


def test_every_line_of_every_table_fits_80_columns(found):
    for grid in show.grids(found):
        assert max(len(line) for line in text(grid).splitlines()) <= 80, text(grid)
    for fact in show.facts(found):
        assert max(len(line) for line in wrapped(fact)) <= 80


def test_the_first_line_says_where_the_data_come_from(found):
    grids = {g.name: g for g in show.grids(found)}
    latex, html = document(grids.values()), page(list(grids.values()), [], {}, [], "sstl reproduce")
    assert latex.count("Data: loops") == html.count("Data: loops") == 3
    for name in ("I", "II", "bias", "R-I", "R-II", "R-III", "IV-sinusoid-rmse", "IV-random-mape"):
        assert text(grids[name]).startswith("Data: ")
    assert "fitted" in text(grids["I"]).splitlines()[1] + text(grids["I"]).splitlines()[0]
    assert "elastic rig" in text(grids["IV-sinusoid-rmse"])


def test_what_differs_says_by_how_much(found):
    grids = {g.name: g for g in show.grids(found)}
    row = next(r for r in grids["IV-sinusoid-rmse"].rows if r[:2] == ("none", "CP"))
    # 4.645 of 5.75 printed
    assert row[2] == "5.75" and row[5] == "4.65x-19"


def test_fourteen_fitted_numbers_are_printed(found):
    said = text(next(g for g in show.grids(found) if g.name == "IV-gap"))
    assert "The 14 fitted numbers" in said and "mismatch rad" in said and "beta_r" in said


def test_fitted_and_predicted_are_counted_apart(found):
    rows = next(g for g in show.grids(found) if g.name == "counts").rows
    whole = {r[2]: [0 if c == "-" else int(c) for c in r[3:]] for r in rows if r[0] == "all"}
    assert sum(whole["fitted"]) + sum(whole["predicted"]) == len(found.compared)
    assert sum(whole["predicted"]) > sum(whole["fitted"]) > 0


def test_facts_say_what_is_outside(found):
    inside = " ".join(show.facts(found))
    assert "87.8 %" in inside and "lie within the committed spread" in inside
    wrong = Outside("rig", ("IV", "sinusoid DI", "rmse_CP"), 0.01, 0.46, 11.0)
    said = " ".join(show.facts(Reproduction(rig=found.rig, outside=(wrong,))))
    assert "1 of 261 entries lie outside" in said


def drawn_axes(drawing):
    axes = Figure().subplots(*drawing.grid, squeeze=False)
    drawing.paint(axes)
    return list(axes.flat)


def test_figure_7_has_every_location_and_method(found):
    drawn = {d.name: d for d in drawings.drawings(found)}
    assert set(drawn) == {"tracking_sinusoid", "tracking_random"} <= set(files.FIGURES)
    for letter, name in (("7a", "tracking_sinusoid"), ("7b", "tracking_random")):
        assert letter in drawn[name].caption
        # the paper shades the sinusoid alone
        shaded = [bool(axes.collections) for axes in drawn_axes(drawn[name])]
        assert shaded == [name == "tracking_sinusoid"] * 3 and ("shaded" in drawn[name].caption) is shaded[0]
        svg = str(picture(drawn[name], None, name).svg)
        assert svg.count("output tension / N") >= 3


def test_figure_6a_says_how_far_line_and_identity_are_off():
    act = np.array([[0.6, 1.5], [0.7, 1.4], [0.8, 1.3], [0.9, 1.2]])
    exact = np.column_stack((act[:, 0] ** 2, 1.5 * act[:, 1] ** 2 - 0.25))
    exact[:, 0] += np.array([0.01, -0.01, -0.01, 0.01])
    words = figures.correlation(act, exact).words
    x = act[:, 1] ** 2
    apart = float(np.sqrt(np.mean((0.5 * x - 0.25) ** 2)))
    # the identity is as good as it can be in pull, and no line in release
    pull, release = re.findall(r"(?:pull|release): the straight line is off by ([\d.e-]+), the identity by ([\d.e-]+)", words)
    assert float(pull[1].rstrip(".")) == 0.01 and float(pull[0]) <= 0.01
    assert float(release[0]) < 1e-12 and float(release[1].rstrip(".")) == pytest.approx(apart, rel=0.05)


def test_document_parts(found):
    made = files.extras(found).plain()
    assert list(made) == ["rig", "closed", "gap"] and set(made) <= set(ReproduceDocument.model_fields)
    assert made["rig"]["seeds"] == [1] and made["rig"]["outside"] == []
    assert [c["right"] for c in made["closed"]] == [True, True, False]
    assert [c["tried"] for c in made["closed"]] == [[], [], ["presliding", "slack"]]


def test_a_simulator_has_a_row_as_given_and_one_with_what_was_put_in(found):
    grid = next(g for g in show.grids(found) if g.name == "gap")
    assert [r[1:4] for r in grid.rows] == [
        ("as given", "", "0.240"),
        ("+ presliding", "yes", "0.090"),
        ("as given", "", "0.300"),
        ("as given", "", "0.240"),
        ("+ presliding + slack", "no", "0.121"),
    ]
    assert any("stribeck (not right): Not known." in n for n in grid.notes)


def test_which_samples_mape_leaves_out_is_said_from_the_scores(found):
    time = np.arange(100) * 0.1
    for least, words in ((0.6, "no sample lies below it"), (0.4, "up to 1 % of the samples lie below it")):
        reference = np.full(100, 5.0)
        reference[7] = least
        made = replace(found.rig[0].tracked, scores={"all": {("random", "DI", "NP"): score(reference, reference + time)}})
        said = show.facts(Reproduction(rig=(replace(found.rig[0], tracked=made),)))[-1]
        assert said.startswith("MAPE has a floor of 0.5 N on the reference: ") and words in said
    assert not any("MAPE" in s for s in show.facts(found))


def test_a_small_difference_is_not_said_to_be_none():
    entry = of_table("IV")[0]
    for mean, said in ((5.67, "x-0.4"), (5.60, "x-2"), (6.60, "x+16")):
        made = compare((entry,), {(entry.table, entry.row, entry.column): mean}, {(entry.table, entry.row, entry.column): (mean, 1e-4)})
        assert mark(made[0]) == said


@pytest.fixture(scope="module")
def beyond():
    """Everything beyond the paper, with values as they come."""
    every = dict.fromkeys(TRAJECTORIES, (0.25, 0.24, 0.26))
    rungs = tuple(Rung(w.name, every, every, every, every, every, every) for w in WAYS)
    probes = tuple(Probe(kind, t, 80.0, 0.0164, None, 0.294, rig, c) for rig, _, c in SETTINGS for kind, t, _ in PLANS)
    fitted = Fitted({("presliding", "breakaway_mm"): 0.185, ("presliding", "spread"): 0.536}, Scenario(), 0.075)
    learned = Calibration(np.eye(3, 2), np.eye(5, 4), (-1.4, -1.0), ModelBench(Scenario()), LoopLag(0.30002, 5e-5, 0.0, 0.02), fitted)
    together = tuple(Together(way, c, c, dict.fromkeys("ABC", 1.16)) for c in (0.0, 0.002) for way in tendons.WAYS)
    bent = tuple(Bent(way, dict.fromkeys(TRAJECTORIES, 1.49), dict.fromkeys(TRAJECTORIES, 12.98), 0.00525, 0.00526) for way in distal.WAYS)
    return Reproduction(calibration=learned, better=rungs, probes=probes, tendons=together, distal=bent)


def test_what_lies_beyond_the_paper_fits_80_columns_and_the_document(beyond):
    grids = show.grids(beyond)
    assert [g.name for g in grids[:3]] == ["identified", "better", "reversal"] and {"tendons", "distal"} <= {g.name for g in grids}
    assert sum(g.name.startswith("probe") for g in grids) == len(SETTINGS)
    for grid in grids:
        assert max(len(line) for line in text(grid).splitlines()) <= 80, text(grid)
    assert "0.3000 +-0.0001" in text(grids[0]) and "0.185" in text(grids[0])
    said = " ".join(show.facts(beyond))
    assert "sinusoid 0.25 N (target 0.45)" in said and "calibrated at two speeds: 0.25 s by Theta" in said
    made = files.extras(beyond).plain()
    assert set(ReproduceDocument.model_fields) >= {"identified", "better", "probe", "tendons", "distal"} == set(made)
    ReproduceDocument(schema="sstl.reproduce/1", seed=1, seeds=5, **made)


def test_figures_beyond_the_paper_say_what_they_show(beyond):
    drawn = {d.name: d for d in drawings.drawings(beyond)}
    assert set(drawn) == {"better", "probe"}
    assert "with drag, two speeds: 0.25 s errs by 1.6 % and 0.29 N" in drawn["probe"].words
    svg = str(picture(drawn["probe"], None, "probe").svg)
    assert "time of the probe" in svg and ">0.25</text>" in svg and ">12</text>" in svg and "mathdefault" not in svg

"""What is printed and drawn, from hand-made results."""

import numpy as np
import pytest

from sstl_cli.cli import _reproduce_files as files
from sstl_cli.control.references import Reference
from sstl_cli.paper import drawings, show
from sstl_cli.paper.block_r import Tracked
from sstl_cli.paper.compare import compare
from sstl_cli.paper.data_seeds import Drawn
from sstl_cli.paper.diagnosed import UNNAMED, Closed
from sstl_cli.paper.gate import Outside
from sstl_cli.paper.grid import text, wrapped
from sstl_cli.paper.published import TABLES, of_table
from sstl_cli.paper.reproduce import Reproduction
from sstl_cli.paper.settings import LOCATIONS, METHODS, TRAJECTORIES
from sstl_cli.paper.spread import stored
from sstl_cli.paper.table_iv_gap import Gap, Share
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
    for name in ("I", "II", "R-I", "R-II", "R-III", "IV-sinusoid-rmse", "IV-random-mape"):
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


def test_figure_7_has_every_location_and_method(found):
    drawn = {d.name: d for d in drawings.drawings(found)}
    assert set(drawn) == {"tracking_sinusoid", "tracking_random"} <= set(files.FIGURES)
    for letter, name in (("7a", "tracking_sinusoid"), ("7b", "tracking_random")):
        assert letter in drawn[name].caption
        svg = str(picture(drawn[name], None, name).svg)
        assert svg.count("output tension / N") >= 3


def test_document_parts(found):
    made = files.extras(found)
    assert made["rig"]["seeds"] == [1] and made["rig"]["outside"] == []
    assert [c["right"] for c in made["closed"]] == [True, True]

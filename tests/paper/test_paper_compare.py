"""Verdicts on hand-made numbers."""

import pytest

from sstl_cli.paper import compare, spread
from sstl_cli.paper.grid import Grid, entry_grids, text, wrapped
from sstl_cli.paper.latex import document
from sstl_cli.paper.published import Entry, of_table

PLAIN = Entry("I", "pull", "R", 0.967, 3)
WRONG = Entry("I", "pull", "R", 0.967, 3, contradicted="because")


@pytest.mark.parametrize(
    ("entry", "value", "mean", "sd", "verdict"),
    [
        (PLAIN, 0.960, 0.960, 0.004, compare.MET),
        (PLAIN, 0.960, 0.958, 0.004, compare.DIFFERS),
        (PLAIN, 0.9672, 0.9672, 0.0, compare.MET),
        (WRONG, 0.958, 0.958, 0.004, compare.CONTRADICTED),
        (WRONG, 0.967, 0.966, 0.004, compare.MET),
        (PLAIN, 0.900, 0.967, 0.004, compare.DIFFERS),
        (PLAIN, None, 0.967, 0.004, compare.UNJUDGED),
        (PLAIN, 0.967, None, None, compare.UNJUDGED),
    ],
)
def test_verdicts(entry, value, mean, sd, verdict):
    assert compare.judge(entry, value, mean, sd)[0] == verdict


def test_a_stale_spread_is_named():
    assert "--spread" in compare.judge(PLAIN, 0.900, 0.967, 0.004)[1]


def test_table_has_a_row_for_every_entry_and_counts_add_up():
    done = compare.compare(of_table("I"), {("I", "pull", "R"): 0.96}, {("I", "pull", "R"): (0.965, 0.01)})
    table = compare.table_of(done)
    assert table.num_rows == 10 and sum(compare.count(done).values()) == 10
    assert table.column("difference")[0].as_py() == pytest.approx(-0.007)
    assert compare.count(done)[compare.UNJUDGED] == 9


def test_spread_file_round_trip():
    made = spread.Spread({"stated": {("I", "pull", "R"): (0.5, 0.25)}, "fitted": {("IV", "a b", "c"): (1.0, 2.0)}}, 7)
    assert spread.parse(made.csv()) == made


def test_stored_spread_covers_every_judged_entry():
    stored = spread.stored()
    assert stored.seeds >= 50
    for table in ("I", "II", "bias", "IV"):
        for e in of_table(table):
            assert (e.table, e.row, e.column) in stored.of("stated")


def test_stored_spread_holds_every_entry_of_tables_i_and_ii():
    stated = spread.stored().of("stated")
    for e in (*of_table("I"), *of_table("II")):
        mean, sd = stated[e.table, e.row, e.column]
        assert abs(mean - e.value) <= 2 * sd + e.rounding, (e.row, e.column)


def test_terminal_tables_fit_80_columns():
    done = compare.compare([*of_table("I"), *of_table("III")], {}, {})
    for grid in entry_grids(done):
        assert max(len(line) for line in text(grid).splitlines()) <= 80
    assert max(len(line) for line in wrapped("word " * 60)) <= 80


def test_latex_escapes_and_uses_booktabs():
    made = document([Grid("x", "100 % & a_b", ("n", "v"), (("a#", "1 +-2"),))])
    assert r"100 \% \& a\_b" in made and r"a\# & 1 $\pm$2 \\" in made and r"\toprule" in made

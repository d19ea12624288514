"""Tables and sentences at 80 columns: names whole or broken behind a separator, numbers never, long ones cut with a count."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sstl_cli.cli import _table
from sstl_cli.cli.render import Screen
from sstl_cli.core.numbers import small

RUN = "CP-020-0-trapezoid-act"


def drawn(header, rows, numeric, width=80):
    return _table.lines(header, rows, numeric, width)


def test_a_run_id_is_broken_behind_a_separator_only():
    rows = [[RUN, "x " * 30 + "end", "-1.5"], ["plain", "text", "2"]]
    found = drawn(["run", "remark", "N"], rows, [False, False, True], 50)
    assert max(map(len, found)) <= 50
    column = [line[: found[0].index("remark")].strip() for line in found[2:]]
    parts = [c for c in column if c and c != "plain"]
    assert "".join(parts) == RUN
    assert all(p.endswith("-") for p in parts[:-1])


def test_numbers_are_never_broken_and_stand_right():
    found = drawn(["run", "value"], [[RUN, "-0.05703..30.05"], ["b", "1"]], [False, True], 20)
    assert any(line.endswith("-0.05703..30.05") for line in found)
    assert found[-1].endswith(" 1")


def test_headings_wrap_before_names_do():
    found = drawn(["run", "backlash handling"], [[RUN, "1.5"]], [False, True], 32)
    assert any(RUN in line for line in found) and any(line.endswith("backlash") for line in found)


def test_a_heading_keeps_its_unit_beside_it():
    rows = [["pulley_friction", "92.86", "a long list of parameters that takes the rest"]]
    found = drawn(["effect", "shrink %", "parameters"], rows, [False, True, False], 60)
    assert "shrink %" in found[0] and max(map(len, found)) <= 60


@given(st.lists(st.tuples(st.text("abc-_/. é漢", max_size=40), st.integers(-(10**9), 10**9)), min_size=1, max_size=5), st.integers(30, 120))
def test_nothing_is_lost_and_the_width_is_kept(rows, width):
    found = drawn(["name", "n"], [[t, str(n)] for t, n in rows], [False, True], width)
    assert max(map(_table.columns, found)) <= width
    shown = "".join("".join(found[2:]).split())
    for text, number in rows:
        assert str(number) in shown
        assert all(shown.count(c) >= text.count(c) for c in "abcé漢")


def test_long_tables_are_cut_with_a_count(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    Screen().table("t", ("n",), [(i,) for i in range(30)], most=20)
    out = capsys.readouterr().out
    assert "and 10 more rows; --json has all" in out and re.search(r"^19$", out, re.M) and not re.search(r"^ ?20$", out, re.M)


def test_sentences_break_between_words(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    Screen().say(f"  record next: the movement of {RUN} and another one")
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 40 and RUN in out
    assert all(line.startswith("  ") for line in out.splitlines())


@pytest.mark.parametrize(("value", "shown"), [(3e-13, "< 0.001"), (-3e-13, "< 0.001"), (0.0, 0.0), (0.2, 0.2), (None, None)])
def test_small_numbers_say_so(value, shown):
    assert small(value) == shown

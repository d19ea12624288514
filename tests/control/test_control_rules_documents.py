"""Rules of the C code, of documents and of references, each just at its limit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers_control import TABLE_II

from sstl_cli.control import references
from sstl_cli.control.c_source import c_source
from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.parameters import controller_of, document, index_of
from sstl_cli.control.parameters import read as read_document
from sstl_cli.control.reference_file import read as read_reference
from sstl_cli.control.scoring import score, windows
from sstl_cli.core.errors import SstlError

LINES = Theta(*TABLE_II)
EVEN = Theta(0.5, 0.0, 2.0, 0.0)


def test_constants_of_the_c_code() -> None:
    code = c_source(Controller(LINES, Options(max_rate_n_s=100.0, hold_s=0.1)), "CP")
    for text in (
        "T_MAX = (sstl_real)0x1.4000000000000p+6; /* 80 */",
        "HOLD = 50L; /* samples */",
        "/* 1e-12 N */",
        "STEP_MAX = (sstl_real)0x1.999999999999ap-3; /* 0.2 */",
    ):
        assert text in code.source
    single = c_source(Controller(LINES), "CP", real="float").source
    assert "/* 1e-05 N */" in single and "STEP_MAX = (sstl_real)0x0.0p+0; /* 0 */" in single and "fabsf" in single


def test_documents_choose_and_drive() -> None:
    made = document({"A": LINES, "B": EVEN}, Options(t_max_n=50.0), "none").plain()
    found = read_document(made, "here")
    assert found.choose("B").lines() == EVEN and index_of(["A"], None) == 0
    assert controller_of(found.choose("A"), found.options).step(12.0, 12.0) == (12.0, "PP")
    with pytest.raises(SstlError, match=r"2 configurations \(A, B\)"):
        found.choose(None)
    for n, shown in ((8, "7)"), (9, "7, ...)")):
        with pytest.raises(SstlError) as told:
            index_of([str(k) for k in range(n)], None)
        assert shown in str(told.value)


def test_reference_files(tmp_path) -> None:
    rows = ["time_s\ttension_ref_n", "0\t1", "1\t3", "2\t5", "0\t9", "1\t9"]
    (tmp_path / "r.tsv").write_text("\n".join(rows))
    # a second run begins where time runs back
    found = read_reference(tmp_path / "r.tsv", 0.5)
    assert found.tension_n.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0] and found.name == "r"
    (tmp_path / "r.csv").write_text("time_s,tension_ref_n\n0,1\n1,2\n1,3\n2,3")
    with pytest.raises(SstlError, match="does not rise at sample 2"):
        read_reference(tmp_path / "r.csv", 0.5)


def test_references_need_a_period_and_not_too_many() -> None:
    y = np.array([1.0, 2.0])
    assert len(references.from_samples("x", np.array([0.0, 0.1]), y, 0.1).time_s) == 2
    assert len(references.from_samples("x", np.array([0.0, 0.1 * (1 - 0.8e-6)]), y, 0.1).time_s) == 2
    for end in (0.0999, 0.1 * (1 - 1.25e-6), 1.1e6):
        with pytest.raises(SstlError, match=r"not 1 to 1e\+07"):
            references.from_samples("x", np.array([0.0, end]), y, 0.1)
    assert references.Reference("late", np.array([5.0, 5.5]), y, 1.0).dt_s == 0.5
    assert references.sinusoid().dt_s == references.trapezoid().dt_s == 0.002
    assert len(references.make("sinusoid", np.random.default_rng(0)).time_s) == 100_000
    with pytest.raises(SstlError, match="no reference 'x'"):
        references.make("x", np.random.default_rng(0))


def test_first_cycle_counts_turns_of_more_than_a_tenth() -> None:
    # turns of 0.9 of 10 N are none; the top at 3 and the bottom at 6 are
    x = np.array([0.0, 5.0, 4.1, 10.0, 9.2, 5.0, 0.5, 1.2, 6.0])
    assert references.first_cycle_s(10.0 + np.arange(9.0), x) == 6.0
    assert references.first_cycle_s(np.arange(9.0), 10.0 - x) == 6.0
    # turns of 1.2 of 10 N are
    assert references.first_cycle_s(np.arange(5.0), np.array([0.0, 5.0, 3.8, 10.0, 0.0])) == 2.0
    # a flat turn ends with its last sample
    assert references.first_cycle_s(np.arange(7.0), np.array([0.0, 5.0, 5.0, 0.0, 0.0, 0.0, 3.0])) == 5.0


def test_scores_at_the_floor_and_windows_at_the_edge() -> None:
    s = score(np.array([0.5, 0.49]), np.array([1.0, 1.0]))
    assert s.mape_pct == pytest.approx(100.0) and s.masked_pct == 50.0 and s.mape_floor_n == 0.5
    assert s.mape_bound_pct == pytest.approx(100.0)
    two = score(np.array([1.0, 2.0]), np.array([2.0, 2.5]))
    assert two.mape_bound_pct == pytest.approx(100 * math.sqrt((1 + 0.25) / 2 * (1 + 0.25) / 2))
    time = 5.0 + np.arange(10.0)
    assert windows(time, 8.0)["without first cycle"] == slice(8, None)
    assert list(windows(time, 9.0)) == list(windows(time, 0.0)) == ["all"]
    for a, b in ((np.empty(0), np.empty(0)), (np.ones(2), np.ones(3))):
        with pytest.raises(SstlError, match="E409"):
            score(a, b)

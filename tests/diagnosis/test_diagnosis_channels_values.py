"""Numbers of channels beside the output that nobody else looks at, and what simpler rules do at a tie."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.diagnosis import channels, simple
from sstl_cli.diagnosis.channels import ChannelGap, log_gain
from sstl_cli.diagnosis.features import BESIDE, CandidateRow
from sstl_cli.diagnosis.gap import Errors
from sstl_cli.physics.filters import first_order

T = np.arange(0.0, 20.0, 0.02)


def test_a_gap_says_by_how_much_its_error_falls():
    gap = ChannelGap("tension_in", "N", "tension_loop_lag", {"tau_s": 0.1}, 4.0, 1.0, 0.5, 0.0)
    assert gap.fall_pct == 75.0 and ChannelGap("x", "N", "e", {}, 0.0, 0.0, 0.5, 0.0).fall_pct == 100.0
    row = gap.row()
    assert row == CandidateRow(("tension_loop_lag",), BESIDE, 1, 0.0, row.evidence, row.evidence, 4.0, 0.0, 0.0, 0, 1.0, 0.75, None)


def test_a_piece_is_left_by_a_loop_that_begins_where_it_was():
    asked = np.where(T < 1.0, 5.0, 9.0)
    given = first_order(asked, 0.02, 0.3, 0.01, 5.0)
    known = np.arange(len(T)) % 3 == 0
    piece = channels._Piece(asked, given, known, 0.02)
    assert np.abs(piece.left(0.3, 0.01)).max() < 1e-12 and len(piece.left(0.3, 0.01)) == known.sum()
    assert piece.left(0.0, 0.0) == pytest.approx((given - asked)[known])


def test_starts_are_the_best_of_a_grid_for_a_lag_a_limit_and_both():
    asked = 10.0 + 5.0 * np.sin(2.0 * np.pi * T / 4.0)
    piece = channels._Piece(asked, asked, np.ones(len(T), bool), 0.02)
    fastest = float(np.abs(np.diff(asked)).max()) / 0.02
    tried = []

    def residual(p):
        tried.append(tuple(p))
        # the lag of 125 ms, and a limit between the third and the fourth
        return np.array([abs(np.log(p[0] / 0.12)) + abs(np.log(p[1] * fastest * 0.8))])

    lag, limit, both = channels._starts(residual, [piece])
    lags, slews = [1e-4, *(0.5 / 2.0 ** np.arange(1, 7))], [1e-6, *np.geomspace(1.0 / fastest, 0.2, 25)]
    assert np.array(sorted(set(tried))) == pytest.approx(np.array(sorted((a, b) for a in lags for b in slews)))
    near = min(slews[1:], key=lambda s: abs(np.log(s * fastest * 0.8)))
    assert lag == pytest.approx([0.125, 1e-6]) and limit == pytest.approx([1e-4, near]) and both == pytest.approx([0.125, near])
    # where nothing is asked for in a hurry no limit is one
    slow = channels._Piece(np.full(len(T), 3.0), asked, np.ones(len(T), bool), 0.02)
    assert [float(s[1]) for s in channels._starts(residual, [slow])] == [1e-6]


def test_a_gain_counts_by_how_evenly_models_differ():
    rng = np.random.default_rng(5)
    base, best = rng.standard_normal(400) * 3.0, rng.standard_normal(400)
    left = base - 2.0 * np.where(np.arange(400) < 200, 1.0, 0.0)
    # as large where models differ as elsewhere, or larger: then only some of them count
    loud = best * np.where(np.arange(400) < 200, 3.0, 0.1)
    even = np.mean((base - left) ** 2) * np.mean(loud**2) / np.mean((base - left) ** 2 * loud**2)
    ratio = np.log(np.sqrt(np.mean(base**2)) / np.sqrt(np.mean(left**2)))
    assert even < 0.6 and log_gain(base, left, loud) == pytest.approx(channels._independent(loud) * even * ratio)
    quiet = best * np.where(np.arange(400) < 200, 0.1, 3.0)
    assert log_gain(base, left, quiet) == pytest.approx(channels._independent(quiet) * ratio)
    assert log_gain(base, base, best) == 0.0


def test_simpler_rules_name_nobody_who_is_as_good_as_nothing():
    base = SimpleNamespace(residual=np.full(50, 2.0))
    one = (SimpleNamespace(ids=("a",), fit=SimpleNamespace(residual=base.residual, free=[])),)
    found = SimpleNamespace(sim=SimpleNamespace(weight=np.ones(50)), base=base, singles={"a": one})
    errors = Errors(base.residual, base.residual, 0.0, np.ones(50), np.zeros(50))
    assert simple.answers(found, errors) == simple.Answers("a", None)
    # two samples at least: of none there is no logarithm
    nothing = SimpleNamespace(sim=SimpleNamespace(weight=np.zeros(50)), base=base, singles={"a": one})
    assert simple.answers(nothing, errors).iid_bic is None
    # what leaves nothing at all is better than anything
    exact = (SimpleNamespace(ids=("b",), fit=SimpleNamespace(residual=np.zeros(50), free=[None] * 5)),)
    assert simple.answers(SimpleNamespace(**{**vars(found), "singles": {"a": one, "b": exact}}), errors) == simple.Answers("b", "b")

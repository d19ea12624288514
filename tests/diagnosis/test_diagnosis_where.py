"""Shares of the squared error, counted by hand."""

from __future__ import annotations

import numpy as np
import pytest
from made_sims import sim

from sstl_cli.diagnosis.where import PHASES, bands, phases, shares

UP = np.arange(0.0, 10.0)


def test_phases_follow_the_input_and_the_output_of_the_model():
    u = np.concatenate([UP, UP[::-1]])
    # it waits for four samples, moves, waits on the way back, moves
    moves = np.concatenate([np.zeros(4), np.arange(1.0, 7.0), np.full(5, 6.0), np.arange(5.0, 0.0, -1.0)])
    named = [PHASES[k] for k in phases(sim((u, {})), moves)]
    assert named[:3] == ["PB"] * 3 and named[4:9] == ["PP"] * 5
    assert named[11:14] == ["RB"] * 3 and named[15:] == ["RP"] * 5


def test_a_hold_of_the_input_belongs_to_the_movement_before_it():
    u = np.concatenate([np.full(5, 9.0), 9.0 - UP, np.full(6, 0.0)])
    named = [PHASES[k] for k in phases(sim((u, {})), np.zeros(len(u)))]
    assert set(named) == {"RB"}


def test_shares_are_of_the_weighted_squared_error():
    made = sim((UP, {"config": 0}), (UP, {"config": 1, "system": "sstl"}), configs=("a", "b"))
    error, code = np.repeat([1.0, 3.0], 10), np.array([0] * 5 + [1] * 5 + [3] * 10)
    made.weight[10:15] = 0.0
    rows = shares(made, error, code)
    # 5 x 1, 5 x 1 and 5 x 9 of 55
    assert [(r.system, r.phase, r.config_id) for r in rows] == [("sstl", "RP", "b"), ("act", "PB", "a"), ("act", "PP", "a")]
    assert [r.share_pct for r in rows] == pytest.approx([100 * 45 / 55, 100 * 5 / 55, 100 * 5 / 55])
    assert [r.rmse_n for r in rows] == [3.0, 1.0, 1.0]


def test_no_error_has_no_share():
    rows = shares(sim((UP, {})), np.zeros(10), np.zeros(10, int))
    assert [r.share_pct for r in rows] == [0.0]


def test_bands_by_direction_time_and_tension():
    u = np.concatenate([UP, UP[::-1]])
    error = np.where(np.arange(20) < 10, 1.0, 0.0)
    found = bands(sim((u, {})), error)
    by_way = {r.name: r.share_pct for r in found["direction"]}
    assert by_way["pull"] == pytest.approx(100.0)
    assert [r.share_pct for r in found["time_in_run"]] == pytest.approx([50.0, 50.0, 0.0, 0.0])
    assert found["tension_n"][0].low == 0.0 and found["tension_n"][-1].high == 9.0
    for rows in found.values():
        assert sum(r.share_pct for r in rows) == pytest.approx(100.0)


def test_bands_by_quarter_and_by_time_since_the_last_turn():
    u = np.concatenate([UP, UP[::-1]])
    found = bands(sim((u, {})), np.sqrt(np.repeat([1.0, 2.0, 3.0, 4.0], 5)))
    assert [r.share_pct for r in found["time_in_run"]] == pytest.approx([10.0, 20.0, 30.0, 40.0])
    # a second up and a second down at 0.1 s: two samples below 0.2 s, three below 0.5 s, five below 1 s after each turn
    even = bands(sim((u, {})), np.ones(20))["time_since_reversal_s"]
    assert [r.share_pct for r in even] == pytest.approx([20.0, 30.0, 50.0, 0.0, 0.0, 0.0])
    assert [r.low for r in even] == [0.0, 0.2, 0.5, 1.0, 2.0, 5.0]


def test_bands_have_the_edges_of_what_they_divide():
    found = bands(sim((np.concatenate([UP, UP[::-1]]), {})), np.ones(20))
    edges = {k: [(r.low, r.high) for r in found[k]] for k in ("time_in_run", "time_since_reversal_s", "frequency_hz")}
    assert edges["time_in_run"] == [(0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1.0)]
    quarters = [(r.low, r.high) for r in found["tension_n"]]
    assert quarters == [(0.0, 2.0), (2.0, 4.5), (4.5, 7.0), (7.0, 9.0)]
    # each band ends where the next one begins, the last at infinity
    for k in ("time_since_reversal_s", "frequency_hz"):
        assert edges[k][0][0] == 0.0 and edges[k][-1][1] == np.inf
        assert [a[1] for a in edges[k][:-1]] == [b[0] for b in edges[k][1:]]
    # a constant error is at no frequency
    assert [r.share_pct for r in found["frequency_hz"]] == pytest.approx([100.0] + [0.0] * (len(edges["frequency_hz"]) - 1))


def test_bands_by_speed_are_quartiles_whatever_the_direction():
    # the rate of u = t^2 at 0.1 s a sample grows from 0.1 on; the last quarter of the samples carries all
    t = np.arange(0.0, 4.0, 0.1)
    rows = bands(sim((-(t**2), {})), np.where(np.arange(40) >= 31, 1.0, 0.0))["rate_n_s"]
    assert [r.share_pct for r in rows] == pytest.approx([0.0, 0.0, 0.0, 100.0])
    assert rows[0].low >= 0.0 and rows[-1].high == pytest.approx(7.7)


def test_averaged_inputs_have_the_phases_of_their_means():
    fine = np.repeat(np.concatenate([UP, UP[::-1]]), 4) + np.tile([-0.3, 0.3, -0.1, 0.1], 20)
    coarse = phases(sim((fine, {"factor": 4})), np.zeros(20))
    assert np.array_equal(coarse, phases(sim((np.concatenate([UP, UP[::-1]]), {})), np.zeros(20)))


@pytest.mark.parametrize("hz, band", [(0.1, 1), (0.5, 2), (2.0, 3)])
def test_an_oscillation_is_found_in_its_band(hz, band):
    t = np.arange(0.0, 40.0, 0.1)
    rows = bands(sim((np.sin(t), {})), np.sin(2.0 * np.pi * hz * t))["frequency_hz"]
    assert rows[band].share_pct == pytest.approx(100.0)


def test_by_frequency_nothing_of_the_error_is_lost():
    rng = np.random.default_rng(0)
    for n in (40, 41):
        error = rng.standard_normal(n)
        rows = bands(sim((np.arange(float(n)), {})), error)["frequency_hz"]
        assert sum(r.share_pct for r in rows) == pytest.approx(100.0)
    constant = bands(sim((np.arange(40.0), {})), np.ones(40))["frequency_hz"]
    assert constant[0].share_pct == pytest.approx(100.0)

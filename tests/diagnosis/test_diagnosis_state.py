"""The state of a rig with friction: direction, way since the turn, and functions over it, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import simulator

from sstl_cli.diagnosis import state

SIM = simulator()


def test_direction_and_way_since_the_turn_by_hand():
    u = np.array([1.0, 0.0, 5.0, 10.0, 9.8, 10.0, 6.0, 2.0, 3.0, 8.0])
    way, last = state.turning(u)
    # the first step is a turn of its own; 0.2 of 10 is none
    assert way.tolist() == [-1, -1, 1, 1, 1, 1, -1, -1, 1, 1]
    assert last == pytest.approx([0.0, 1.0, 5.0, 10.0, 9.8, 10.0, 4.0, 8.0, 1.0, 6.0])
    assert state.turning(np.array([0.0, 1.0, 3.0, 2.9]))[0].tolist() == [1, 1, 1, 1]
    # what never moves pulls
    assert state.turning(np.full(4, 3.0))[0].tolist() == [1, 1, 1, 1]


def test_a_reversal_is_where_the_signal_stood_farthest_not_where_it_shows():
    # 5 % of the span of 100 shows a reversal; it began at the top
    u = np.array([0.0, 50.0, 99.0, 100.0, 98.0, 96.0, 94.0, 50.0, 0.0])
    way, since = state.turning(u)
    assert way.tolist() == [1, 1, 1, 1, -1, -1, -1, -1, -1]
    assert since == pytest.approx([0, 50, 99, 100, 2, 4, 6, 50, 100])


def test_hats_share_a_place_between_its_knots_and_stay_beyond_the_ends():
    hats = state.hats(np.array([-1.0, 0.0, 0.5, 2.0, 9.0]), np.array([0.0, 2.0, 4.0]))
    assert hats.tolist() == [[1, 0, 0], [1, 0, 0], [0.75, 0.25, 0], [0, 1, 0], [0, 0, 1]]
    assert state.hats(np.array([3.0, 4.0]), np.array([1.0])).tolist() == [[1.0], [1.0]]
    knots = state.knots(np.linspace(0.0, 100.0, 101), 3)
    assert knots == pytest.approx([1.0, 50.0, 99.0]) and state.knots(np.full(5, 2.0), 3).tolist() == [2.0]


def test_a_place_of_the_map_is_input_then_the_other_pulling_then_releasing():
    design = state.design(np.array([1.0, 2.0]), np.array([0.0, 1.0]), np.array([1.0, -1.0]), np.array([0.0, 2.0]), np.array([0.0, 1.0]))
    assert design.tolist() == [[0.5, 0, 0.5, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 1.0]]


def part(n=400, factor=1):
    """Return a record whose input goes up and down between 0 and 100 N, four times."""
    u = 100.0 * np.abs((np.arange(n * factor) / (n * factor) * 4.0) % 1.0 * 2.0 - 1.0)
    return replace(SIM.problem.records[0], u=u, y=np.zeros(n), weight=np.ones(n), factor=factor, dt_s=0.02 / factor)


def test_the_state_of_a_record_is_averaged_and_along_the_stroke_where_a_motion_drives_it():
    fine = part(200, 2)
    u, since, way = state.state(fine)
    assert u == pytest.approx(fine.u.reshape(-1, 2).mean(axis=1)) and all(
        np.array_equal(a, b) for a, b in zip((way, since), state.turning(u), strict=True)
    )
    slip = np.repeat([1.0, 0.5, -0.5, -1.0], 100)
    raw = replace(fine.raw, position_in_mm=np.arange(2000.0))
    u, place, way = state.state(replace(fine, slip=slip, raw=raw))
    assert place[:2] == pytest.approx([0.5, 2.5]) and way.tolist() == [1.0] * 100 + [-1.0] * 100


def test_what_is_left_lasts_for_a_time_and_on_the_move_for_a_path():
    r = replace(part(4), rate=np.array([0.0, 10.0, -10.0, 1e9]))
    assert state.lasting(r, 2.0, 20.0) == pytest.approx([2.0, 1.0, 1.0, 0.0], abs=1e-6)
    # where motion drives the line the path is that of the motion
    assert state.lasting(replace(r, slip=np.array([0.0, 0.0, 1.0, 4.0])), 2.0, 2.0) == pytest.approx([2.0, 2.0, 1.0, 0.4])


def test_places_nearby_are_alike_and_the_two_directions_in_part():
    alike = state.alike(3, 2)
    assert alike.shape == (12, 12) and np.array_equal(alike, alike.T) and np.all(np.diag(alike) == 1.0)
    assert np.linalg.eigvalsh(alike).min() > 0.0
    # the second coordinate moves fastest; then the input; then the direction
    assert alike[0, 1] == pytest.approx(np.exp(-1.0 / 2.0)) and alike[0, 2] == pytest.approx(np.exp(-1.0 / 3.0)) and alike[0, 6] == 0.5

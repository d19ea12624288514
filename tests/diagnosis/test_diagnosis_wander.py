"""What a known rig varies by, on small arrays against dense linear algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from sstl_cli.diagnosis.wander import Wander, _likeliest, components, cut, levels, nowhere, turned

RNG = np.random.default_rng(7)
N = 60
STRETCHES = [slice(0, 20), slice(20, 45), slice(45, 60)]
D = RNG.standard_normal((N, 3)) * np.array([1.0, 0.3, 2.0])


def covariance(d=D, stretches=STRETCHES):
    """Return the covariance of unit noise and of directions that are drawn anew in every stretch."""
    c = np.eye(N)
    for s in stretches:
        c[s, s] += d[s] @ d[s].T
    return c


def test_what_varies_is_white_again_after_it():
    turn = turned(D, STRETCHES)
    root = turn(np.eye(N))
    assert root @ covariance() @ root.T == pytest.approx(np.eye(N), abs=1e-9)
    assert turn.log_det == pytest.approx(np.linalg.slogdet(covariance())[1])


def test_directions_that_are_one_count_once():
    twice = np.column_stack((D, D[:, 0]))
    turn = turned(twice, STRETCHES)
    root = turn(np.eye(N))
    assert root @ covariance(twice) @ root.T == pytest.approx(np.eye(N), abs=1e-9)


def test_a_direction_that_does_not_show_is_nothing():
    turn = turned(np.zeros((N, 2)), STRETCHES)
    x = RNG.standard_normal((N, 2))
    assert np.array_equal(turn(x), x) and turn.log_det == 0.0


def test_levels_follow_one_another():
    def blocks(level):
        rows = [np.arange(60)[b] for b in level[1]]
        return [(r[0], r[-1] + 1, len(r)) for r in rows]

    one = Wander(D[:20, :1], D[:20, 1:2], D[:20, :1], D[:20, 2:], (slice(0, 10), slice(10, 20)))
    stretch, run, bend, whole = levels([one] * 3, [20] * 3, ["a", "b", "a"])
    assert blocks(stretch) == [(a, a + 10, 10) for a in range(0, 60, 10)]
    assert blocks(run) == [(0, 20, 20), (20, 40, 20), (40, 60, 20)] and blocks(whole) == [(0, 60, 60)]
    # what was recorded of one bend need not be recorded in a row
    assert blocks(bend) == [(0, 60, 40), (20, 40, 20)]
    assert stretch[0].shape == run[0].shape == bend[0].shape == whole[0].shape == (60, 1)


def test_no_level_where_a_record_is_not_known():
    assert levels([None, None], [30, 30], "ab") is None
    some = replace(nowhere(30), stretch=D[:30], stretches=(slice(0, 30),))
    assert levels([some, None], [30, 30], "ab") is None
    # columns that are not there are no level
    assert len(levels([some], [30], "a")) == 1


def drawn(sizes, stretches, directions, seed):
    rng = np.random.default_rng(seed)
    z = rng.standard_normal(len(directions))
    for s in stretches:
        z[s] += directions[s] @ (sizes * rng.standard_normal(len(sizes)))
    return z


def test_a_variation_is_found_as_large_as_it_is():
    rng = np.random.default_rng(3)
    many = [slice(20 * i, 20 * i + 20) for i in range(60)]
    directions = rng.standard_normal((1200, 3))
    found = components(directions, drawn(np.array([0.0, 2.0, 0.0]), many, directions, 5), many)
    assert found[1] == pytest.approx(2.0, rel=0.25) and max(found[0], found[2]) < 0.2


def test_two_directions_that_vary_are_found_one_after_the_other():
    rng = np.random.default_rng(12)
    many = [slice(20 * i, 20 * i + 20) for i in range(60)]
    directions = rng.standard_normal((1200, 3))
    found = components(directions, drawn(np.array([2.0, 1.0, 0.0]), many, directions, 13), many)
    assert found[:2] == pytest.approx([2.0, 1.0], rel=0.25) and found[2] < 0.2
    # in the units of the directions, however small those are
    small = components(1e-6 * directions, drawn(np.array([2.0, 1.0, 0.0]), many, directions, 13), many)
    assert small == pytest.approx(1e6 * found)


def test_what_varies_by_next_to_nothing_adds_as_little():
    turn = turned(1e-6 * D, STRETCHES)
    # ln det(1 + D D') is the trace of D D' where that is small
    assert turn.log_det == pytest.approx(1e-12 * float(np.sum(D**2)), rel=1e-6)
    none = turned(np.zeros((N, 0)), STRETCHES)
    assert none.log_det == 0.0 and np.array_equal(none(D), D)


def test_the_likeliest_variance_is_what_scores_show_beyond_their_noise():
    # a thousand stretches that tell a direction to 1/10 each: estimates scatter by 0.3 and by that
    rng = np.random.default_rng(15)
    information = np.full((1000, 2), 100.0)
    score = np.column_stack((100.0 * np.hypot(0.3, 0.1) * rng.standard_normal(1000), 10.0 * rng.standard_normal(1000)))
    variance, gain = _likeliest(information, score)
    assert variance[0] == pytest.approx(0.09, rel=0.2)
    # by the normal densities of both
    sd = np.sqrt(100.0 * (1.0 + 100.0 * variance[0]))
    expected = norm.logpdf(score[:, 0], 0.0, sd).sum() - norm.logpdf(score[:, 0], 0.0, 10.0).sum()
    assert gain[0] == pytest.approx(expected) and gain[1] < 1.0
    nowhere_seen = _likeliest(np.zeros((3, 1)), np.zeros((3, 1)))
    assert nowhere_seen[1].tolist() == [0.0] and np.isfinite(nowhere_seen[0]).all()


def test_nothing_varies_where_nothing_does():
    rng = np.random.default_rng(4)
    many = [slice(20 * i, 20 * i + 20) for i in range(60)]
    directions = rng.standard_normal((1200, 3))
    # a stretch tells a direction to 0.22 (one over the root of its 20 samples)
    assert np.max(components(directions, drawn(np.zeros(3), many, directions, 6), many)) < 0.2


def test_two_runs_and_many_directions_that_do_not_vary_leave_nothing_that_does():
    two = [slice(0, 200), slice(200, 400)]
    seen = 0
    for seed in range(20):
        directions = np.random.default_rng(seed).standard_normal((400, 12))
        seen += np.count_nonzero(components(directions, drawn(np.zeros(12), two, directions, 100 + seed), two))
    assert seen <= 4


def test_directions_that_show_alike_are_never_large_against_each_other():
    rng = np.random.default_rng(8)
    many = [slice(20 * i, 20 * i + 20) for i in range(5)]
    one = rng.standard_normal((100, 1))
    # all but the same, and one that shows nowhere
    directions = np.column_stack((one, one + 1e-6 * rng.standard_normal((100, 1)), np.zeros(100)))
    found = components(directions, drawn(np.array([1.0, 0.0, 0.0]), many, directions, 9), many)
    assert np.count_nonzero(found) == 1 and found.max() < 3.0 and found[2] == 0.0


def test_of_two_that_nearly_cancel_one_another_neither_varies_by_more_than_it_shows_alone():
    rng = np.random.default_rng(10)
    first, apart = np.linalg.qr(rng.standard_normal((200, 2)))[0].T * 20.0
    directions, whole = np.column_stack((first, first + 0.3 * apart)), [slice(0, 200)]
    # nearly all along what tells one from the other
    left = 0.05 * first + 0.5 * apart + rng.standard_normal(200)
    alone = [components(directions[:, [i]], left, whole)[0] for i in range(2)]
    found = components(directions, left, whole)
    assert found[1] == pytest.approx(alone[1]) and 0.0 < found[0] <= 1.0 / 20.0 + 1e-9 and alone[0] == 0.0


def test_stretches_are_as_long_as_asked_and_fill_the_record():
    assert cut(10, 5.0, 2.5) == [slice(0, 5), slice(5, 10)]
    assert cut(10, 5.0, 99.0) == [slice(0, 10)]
    parts = cut(11, 5.0, 1.6)
    assert [s.start for s in parts[1:]] == [s.stop for s in parts[:-1]] and parts[-1].stop == 11


def test_what_is_read_late_varies_late():
    rng = np.random.default_rng(5)
    known = Wander(
        rng.standard_normal((30, 2)), np.zeros((30, 0)), rng.standard_normal((30, 1)), rng.standard_normal((30, 1)), (slice(0, 30),)
    )
    late = known.late(3.0)
    assert late.stretch[3:] == pytest.approx(known.stretch[:-3]) and late.whole[3:] == pytest.approx(known.whole[:-3])
    assert late.bend[3:] == pytest.approx(known.bend[:-3])
    assert late.stretch[:3] == pytest.approx(np.repeat(known.stretch[:1], 3, axis=0))
    assert late.run.shape == (30, 0) and late.stretches == known.stretches

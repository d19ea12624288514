"""How far the gap shrinks, and intervals, on residuals whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, made, noise, simulator
from made_sims import sim

from sstl_cli.diagnosis import shrink
from sstl_cli.diagnosis.heldout import blocks
from sstl_cli.diagnosis.hypotheses import Hypothesis, full
from sstl_cli.diagnosis.shrink import Interval, _draws, identifiability, parameter_intervals, shrinkage, worse_regions

U = np.arange(200.0)
OUT = Hypothesis(("zero_offset",), tuple(f for f in full("zero_offset", ("act",)).free if f.parameter.name == "z_out_act_n"))


def test_an_error_that_halves_everywhere_shrinks_by_half_for_sure():
    made_sim = sim((U, {}), (U, {}))
    found = shrinkage(made_sim, np.full(400, 2.0), np.full(400, 1.0))
    assert (found.estimate, found.low, found.high) == pytest.approx((50.0, 50.0, 50.0))


def test_noise_above_the_analysis_rate_is_in_both_errors():
    found = shrinkage(sim((U, {}), (U, {})), np.full(400, 2.0), np.full(400, 1.0), fine_n=1.0)
    assert found.estimate == pytest.approx(100.0 * (1.0 - np.sqrt(2.0 / 5.0)))


def test_a_record_of_one_block_has_no_interval():
    made_sim = sim((U[:40], {}))
    assert shrinkage(made_sim, np.full(40, 2.0), np.full(40, 1.0)) is None
    # what is masked is no part of it
    longer = sim((U, {}))
    longer.weight[40:] = 0.0
    assert shrinkage(longer, np.full(200, 2.0), np.linspace(0.5, 1.5, 200)) is None


def test_samples_without_weight_do_not_count():
    made_sim = sim((U, {}), (U, {}))
    made_sim.weight[200:] = 0.0
    other = np.repeat([1.0, 50.0], 200)
    assert shrinkage(made_sim, np.full(400, 2.0), other).estimate == pytest.approx(50.0)


def test_runs_that_disagree_make_the_interval_wide():
    found = shrinkage(sim((U, {}), (U, {}), (U, {})), np.full(600, 2.0), np.repeat([0.5, 1.0, 1.9], 200))
    assert found.low < found.estimate < found.high and found.high - found.low > 30.0


def test_every_block_of_a_draw_is_one_of_the_run_drawn_for_its_place():
    run_of_block = np.array([0, 0, 0, 1, 1])
    drawn = run_of_block[_draws(run_of_block)]
    assert drawn.shape == (1000, 5) and {tuple(np.unique(row[:3])) for row in drawn} <= {(0,), (1,)}
    assert (drawn[:, 0] == drawn[:, 2]).all() and (drawn[:, 3] == drawn[:, 4]).all()


def test_the_interval_of_an_offset_is_at_least_what_the_noise_gives():
    f = made(noise(), OUT, (0.1,))
    (found,) = parameter_intervals(simulator(), f)
    assert found.estimate == 0.1 and found.low < 0.1 < found.high
    # theta moves with it: it cannot be known better than from white noise about a constant alone
    assert 0.5 * (found.high - found.low) >= 1.96 * NOISE_N / np.sqrt(len(f.residual))


def test_coloured_misfit_widens_the_interval():
    slow = 0.1 * np.sin(np.arange(len(simulator().y)) / 200.0)
    (quiet,), (loud,) = (parameter_intervals(simulator(), made(left, OUT, (0.1,))) for left in (noise(), noise() + slow))
    assert loud.high - loud.low > 3.0 * (quiet.high - quiet.low)


def test_what_the_data_do_not_hold_has_no_interval():
    f = made(noise(), OUT, (0.1,))
    blind = replace(f, jacobian=f.jacobian * np.array([1.0, 0.0]))
    assert parameter_intervals(simulator(), blind) == [None]
    assert identifiability(blind, 0, None) == "not_identifiable"


@pytest.mark.parametrize(
    "half_width, estimate, label",
    [(0.1, 0.5, "identifiable"), (0.24, 0.25, "identifiable"), (0.3, 0.2, "weak"), (0.6, 0.7, "weak"), (2.1, 3.0, "not_identifiable")],
)
def test_a_strength_is_identifiable_when_its_interval_is_narrow_and_clear_of_neutral(half_width, estimate, label):
    f = made(0.0, OUT, (estimate,))
    width = f.free[0].width
    interval = Interval(estimate * width, (estimate - half_width) * width, (estimate + half_width) * width)
    assert identifiability(f, 0, interval) == label


def test_regions_are_worse_by_more_than_a_tenth_and_by_enough_of_the_whole():
    made_sim = sim((U, {}), (U, {"system": "sstl"}))
    code = np.tile(np.repeat([0, 1, 2, 3], 50), 2)
    base = np.ones(400)
    other = base.copy()
    other[:50] = 1.2
    other[50:100] = 1.05
    assert worse_regions(made_sim, base, other, code) == ["act PB"]
    # twice a next to nothing is next to nothing
    base[200:250], other[200:250] = 0.01, 0.02
    assert worse_regions(made_sim, base, other, code) == ["act PB"]


def test_the_interval_of_coloured_misfit_is_the_sandwich_over_blocks():
    left = noise(4) + 0.1 * np.sin(np.arange(len(simulator().y)) / 200.0)
    f = made(left, OUT, (0.1,))
    (found,) = parameter_intervals(simulator(), f)
    j, r = f.whiten(f.jacobian), f.whiten(f.residual)
    dense = np.column_stack((j[:, :1] * (simulator().config[:, None] == np.arange(2)), j[:, 1]))
    index = blocks(simulator())
    scores = np.array([dense[index == b].T @ r[index == b] for b in range(index.max() + 1)])
    inverse = np.linalg.inv(dense.T @ dense)
    n = len(scores)
    se = np.sqrt((inverse @ scores.T @ scores @ inverse)[2, 2] * n / (n - 3))
    assert found.high - found.estimate == pytest.approx(1.96 * se, rel=1e-4) and found.estimate - found.low == pytest.approx(
        1.96 * se, rel=1e-4
    )
    # more than white noise gives
    assert se > 2.0 * np.sqrt(inverse[2, 2])


@pytest.mark.parametrize(("size", "grown", "worse"), [(2.0, 1.09, False), (2.0, 1.11, True), (0.5, 1.09, False), (0.5, 1.11, True)])
def test_a_region_is_worse_in_proportion_to_its_own_error(size, grown, worse):
    made_sim = sim((U, {}), (U, {"system": "sstl"}))
    code = np.tile(np.repeat([0, 1, 2, 3], 50), 2)
    base = np.where(np.arange(400) // 50 == 6, size, 0.3)
    other = np.where(np.arange(400) // 50 == 6, grown * size, 0.3)
    assert worse_regions(made_sim, base, other, code) == (["sstl RB"] if worse else [])
    # what has no weight does not count
    made_sim.weight[np.arange(400) // 50 == 6] = 0.0
    assert worse_regions(made_sim, base, other, code) == []


def test_an_error_that_grows_has_an_interval_below_nothing_and_none_beyond_all():
    made_sim = sim((U, {}), (U, {}), (U, {}), (U, {}))
    rng = np.random.default_rng(3)
    base = rng.standard_normal(800)
    worse = shrinkage(made_sim, base, 1.5 * base)
    assert worse == Interval(pytest.approx(-50.0), pytest.approx(-50.0), pytest.approx(-50.0))
    # of what is known not to shrink at all, and of what shrinks to nothing
    assert shrinkage(made_sim, base, base).estimate == pytest.approx(0.0, abs=1e-9)
    gone = shrinkage(made_sim, base, np.where(np.arange(800) < 200, 1e-3 * base, 0.0))
    assert gone.low <= gone.estimate <= gone.high <= 100.0 and gone.estimate > 99.9


def test_an_interval_reaches_no_further_than_a_parameter_can():
    f = made(noise(), OUT, (0.1,))
    p = OUT.free[0].parameter
    most = p.most - p.least
    assert shrink._interval(f, 0, 0.5) == Interval(0.1, pytest.approx(-0.4), pytest.approx(0.6))
    assert shrink._interval(f, 0, 0.0) is None and shrink._interval(f, 0, 1.01 * most) is None
    assert shrink._interval(f, 0, 0.99 * most) is not None
    silent = replace(f, jacobian=np.zeros_like(f.jacobian))
    assert shrink._interval(silent, 0, 0.5) is None

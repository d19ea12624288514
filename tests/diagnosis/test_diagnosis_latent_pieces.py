"""Corners of a latent input: where they begin, whether they are whole and where else they may be, by the likelihood of the readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit, softmax

from sstl_cli.diagnosis import latent as of
from sstl_cli.diagnosis.constants import DECIDES_NATS, ELSEWHERE, LATENT_ENOUGH_NATS, LEAST_SCALE, ROUNDINGS, STEP_SHARES
from sstl_cli.diagnosis.smoother import Reading, chain, costs, follow
from sstl_cli.diagnosis.tries import costs_of

N, SD = 90, 0.02
NOISE, USE = Reading(SD**2), np.ones(N, bool)
BENDS = np.full(N, 1e-14)


def ramps(*corners, slope=0.05):
    """Return readings of a line that turns at places, and the variances of its steps."""
    way = np.ones(N)
    for k in corners:
        way[k:] *= -1.0
    y = slope * np.cumsum(way) + SD * np.random.default_rng(sum(corners)).standard_normal(N)
    steps = np.full(N, 1e-12)
    steps[list(corners)] = 0.5 * (2.0 * slope) ** 2
    return y - y[0], steps


def path(y, steps, scale=1e-12):
    nats = float(costs(y, USE, NOISE, steps, BENDS).sum())
    return of._by(y, USE, NOISE, of._Path((), (scale, 1e-14), np.zeros((N, 4))), (steps, BENDS), nats)


def total(y, corners):
    return float(costs(y, USE, NOISE, corners, BENDS).sum())


def test_starts_are_shares_of_the_typical_step_and_never_nothing():
    y = np.cumsum(np.cumsum(np.random.default_rng(12).standard_normal(60)))
    typical = [np.median(np.diff(y, order) ** 2) for order in (2, 3)]
    curved, straight = of._starts(y, np.ones(60, bool), 1.0)
    for start, shares in ((curved, STEP_SHARES[0]), (straight, STEP_SHARES[1])):
        assert start.scales == pytest.approx([share * step for share, step in zip(shares, typical, strict=True)])
        assert [set(s) for s in start.steps] == [{start.scales[0]}, {start.scales[1]}] and np.isinf(start.nats)
        # nothing is known of a step yet: all of its square is open
        assert start.squares[:, [1, 3]] == pytest.approx(np.tile(start.scales, (60, 1))) and not start.squares[:, [0, 2]].any()
    # what does not move still has a scale, in the variance of a reading; what says nothing is left out
    still = np.zeros(60)
    assert of._starts(still, np.ones(60, bool), 4.0)[0].scales == pytest.approx(np.array(STEP_SHARES[0]) * 4.0 * LEAST_SCALE)
    spoilt, use = y.copy(), np.ones(60, bool)
    spoilt[::10], use[::10] = 1e6, False
    assert of._starts(spoilt, use, 1.0)[0].scales[0] == pytest.approx(STEP_SHARES[0][0] * np.median(np.diff(y[use], 2) ** 2))


def test_a_corner_is_sharp_by_the_odds_of_its_readings_as_far_as_halfway_to_the_next():
    corners = of._Corners(np.zeros(30), np.array([10, 20]), np.array([0.0, -DECIDES_NATS]))
    p = corners.sharp()
    assert p[:16] == pytest.approx(np.full(16, 49.0 / 50.0)) and p[16:] == pytest.approx(np.full(14, 0.5))
    assert of._Corners(np.zeros(4), np.array([2]), np.array([1.0])).sharp() == pytest.approx(np.full(4, expit(1.0 + DECIDES_NATS)))


@pytest.mark.parametrize("corner", [30, 31])
def test_two_halves_of_a_corner_are_made_one_where_the_readings_like_it(corner):
    # it turns in the middle between two samples
    y = 0.05 * np.cumsum(np.sign(corner - np.arange(N))) + SD * np.random.default_rng(corner).standard_normal(N)
    y -= y[0]
    halves = np.full(N, 1e-12)
    halves[[corner, corner + 1]] = 0.05**2
    split = path(y, halves)
    step = split.mean[1:, 1] - split.mean[:-1, 1] - split.mean[:-1, 2]
    assert step[[corner - 1, corner]].max() < -0.01
    found = of._whole_corners(y, USE, NOISE, split)
    assert found is not None and found.at.tolist() == [corner]
    place = corner + int(np.argmax(found.variances[corner : corner + 2]))
    # one step with all of the turn, and nothing but the usual in the other
    assert found.variances[place] == pytest.approx(0.5e-12 + 0.5 * (step[corner - 1] + step[corner]) ** 2)
    assert found.variances[2 * corner + 1 - place] == 0.5e-12
    others = np.setdiff1d(np.arange(N), [corner, corner + 1])
    assert np.array_equal(found.variances[others], halves[others])
    # by how much the readings like it better than two
    assert found.nats == pytest.approx([total(y, halves) - total(y, found.variances)], abs=1e-6)
    both = [np.full(N, 1e-12) for _ in range(2)]
    for k, one in enumerate(both):
        one[[corner, corner + 1]] = 0.5e-12
        one[corner + k] = found.variances[place]
    assert total(y, both[place - corner]) <= total(y, both[1 - (place - corner)])


def test_a_path_without_a_split_corner_has_none_to_make_whole():
    y, steps = ramps(30, 60)
    assert of._whole_corners(y, USE, NOISE, path(y, steps)) is None
    # steps against one another are no halves of a corner: a jump of the signal is both
    jump = np.where(np.arange(N) < 40, 0.0, 1.0)
    both = np.full(N, 1e-12)
    both[[40, 41]] = 1.0
    assert of._whole_corners(jump, USE, NOISE, path(jump, both)) is None


def test_a_corner_may_be_elsewhere_by_the_likelihood_of_each_place():
    y, steps = ramps(40)
    here = path(y, steps)
    assert of._places(here).tolist() == [40]
    nats, means = [], []
    for by in range(-ELSEWHERE, ELSEWHERE + 1):
        moved = np.full(N, 1e-12)
        moved[40 + by] = steps[40]
        nats.append(total(y, moved))
        means.append(follow(*chain(y, USE, NOISE, moved, BENDS))[0][:, 0])
    p, means = softmax(-np.array(nats)), np.array(means)
    assert 0.1 < p.max() < 0.95
    mean = p @ means
    off, sd = of._elsewhere(y, USE, NOISE, here)
    assert off == pytest.approx(mean - here.mean[:, 0], abs=1e-9)
    assert sd == pytest.approx(np.sqrt(p @ (means - mean) ** 2), abs=1e-9) and sd.max() > 0.05 * SD


def test_each_of_several_corners_has_its_own_places():
    y, steps = ramps(25, 65)
    off, sd = of._elsewhere(y, USE, NOISE, path(y, steps))
    known = costs(y, USE, NOISE, steps, BENDS)
    # of the readings until the next one may be, the other one stays where it is
    for corner, told, part in ((25, slice(0, 65 - ELSEWHERE), slice(0, 40)), (65, slice(0, N), slice(50, N))):
        nats, means = [], []
        for by in range(-ELSEWHERE, ELSEWHERE + 1):
            moved = steps.copy()
            moved[corner], moved[corner + by] = 1e-12, steps[corner]
            nats.append(float((costs(y, USE, NOISE, moved, BENDS) - known)[told].sum()))
            means.append(follow(*chain(y, USE, NOISE, moved, BENDS))[0][:, 0])
        p, means = softmax(-np.array(nats)), np.array(means)
        expected = np.sqrt(p @ (means - p @ means) ** 2)
        assert sd[part] == pytest.approx(expected[part], rel=0.1, abs=0.03 * SD) and np.abs(off[part]).max() < 2.0 * SD
    none = of._elsewhere(y, USE, NOISE, path(y, np.full(N, 1e-12)))
    assert not none[0].any() and not none[1].any()


def test_a_settled_path_is_likelier_than_its_start_and_its_steps_follow_their_expected_squares():
    y, _ = ramps(30, 60)
    start = of._starts(y, USE, SD**2)[1]
    found = of._settled(y, USE, NOISE, start)
    assert found.nats == pytest.approx(
        total(y, found.steps[0]) + float((costs(y, USE, NOISE, *found.steps) - costs(y, USE, NOISE, found.steps[0], BENDS)).sum())
    )
    assert found.nats < float(costs(y, USE, NOISE, *start.steps).sum()) - 10.0
    # corners are where the line turns, and large
    assert set(np.argsort(-found.steps[0])[:2]) <= {29, 30, 31, 59, 60, 61}
    # it has come to rest: once more from there changes next to nothing
    again = of._settled(y, USE, NOISE, replace(found, nats=np.inf), 4)
    assert abs(again.nats - found.nats) < 4.0 * LATENT_ENOUGH_NATS


def test_a_curvature_is_spread_as_far_as_readings_allow_at_49_to_1():
    rng = np.random.default_rng(2)
    y = 1e-4 * (np.arange(N) - 40.0) ** 2 + SD * rng.standard_normal(N)
    y -= y[0]
    bends = np.full(N, 1e-12)
    bends[[20, 45, 70]] = 1e-8
    steps = (np.full(N, 1e-14), bends)
    nats = float(costs(y, USE, NOISE, *steps).sum())
    sharp = of._by(y, USE, NOISE, of._Path((), (1e-14, 1e-12), np.zeros((N, 4))), steps, nats)
    found = of._as_smooth(y, USE, NOISE, sharp)
    asked = [float(costs(y, USE, NOISE, steps[0], of._spread(bends, w)).sum()) for w in ROUNDINGS]
    allowed = [w for w, a in zip(ROUNDINGS, asked, strict=True) if a < nats + DECIDES_NATS]
    assert allowed and found.steps[1] == pytest.approx(of._spread(bends, allowed[-1]))
    assert found.nats == pytest.approx(asked[ROUNDINGS.index(allowed[-1])]) and found.steps[0] is steps[0]
    assert costs_of(y, USE, NOISE, [steps[0]], [found.steps[1]]) == pytest.approx([found.nats])


def test_variances_are_spread_exponentially_and_no_further_than_the_record():
    out = of._spread(np.eye(1, 41, 20)[0], 4.0)
    # what a corner does falls off by 1/e in half a width, and ends at four of them
    assert out.sum() == pytest.approx(1.0) and out[22] / out[20] == pytest.approx(np.exp(-1.0)) and np.count_nonzero(out) == 33
    assert np.count_nonzero(of._spread(np.eye(1, 9, 4)[0], 4.0)) == 9 and len(of._spread(np.ones(8), 4.0)) == 8

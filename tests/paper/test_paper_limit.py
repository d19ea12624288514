"""The closed-form limit against brute force, and the generator against the paper."""

import numpy as np
import pytest

from sstl_cli.paper.limit import bayes, bayes_error, errors, linear_error
from sstl_cli.physics.generator import CP, PLACES, Place, configurations, draw_slopes, generate, log_covariance, log_means


def test_conditional_mean_against_nearest_neighbours_of_a_large_sample():
    rng = np.random.default_rng(3)
    drawn = np.concatenate([draw_slopes(p, 50, rng) for _ in range(2500) for p in PLACES])
    probe = np.array([[0.23, 3.9], [0.27, 3.2], [0.19, 4.9]])
    scale = drawn[:, 2:].std(axis=0)
    for x, predicted in zip(probe, bayes(probe, PLACES, 50), strict=True):
        nearest = np.argsort(np.sum(((drawn[:, 2:] - x) / scale) ** 2, axis=1))[:400]
        near = drawn[nearest, :2]
        assert predicted == pytest.approx(near.mean(axis=0), abs=4 * near.std(axis=0).max() / 20 + 0.003)


def test_no_linear_map_beats_the_limit():
    limit = bayes_error(PLACES, 50, np.random.default_rng(0), 200).total
    linear = [linear_error(PLACES, 50, np.random.default_rng(i)).total for i in range(40)]
    assert limit < np.mean(linear)
    # the scatter is set so that linear regression errs as in Table III
    assert np.mean(linear) == pytest.approx(0.0193, abs=0.0006)
    assert limit < 0.0166


def test_a_loop_without_scatter_leaves_only_the_scatter_of_the_tendon():
    exact = Place("exact", scatter=1e-4)
    gamma = np.exp(log_means(exact, 50)[:, 0])
    expected = np.sqrt(np.mean(gamma**2)) * np.hypot(0.0035, 0.0076)
    assert bayes_error((exact,), 50, np.random.default_rng(0), 200).rmse_p == pytest.approx(expected, rel=0.03)


def test_errors_by_hand():
    e = errors(np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[1.0, 2.0], [2.0, 6.0]]))
    assert (e.rmse_p, e.rmse_r) == pytest.approx((np.sqrt(0.5), np.sqrt(2.0)))
    assert e.total == pytest.approx(np.sqrt(1.25))


def test_covariance_of_draws():
    place = PLACES[0]
    rng = np.random.default_rng(1)
    logs = np.concatenate([np.log(draw_slopes(place, 50, rng)) - log_means(place, 50) for _ in range(2000)])
    assert np.cov(logs.T) == pytest.approx(log_covariance(place), abs=2e-5)


def test_generator_gives_paired_configurations():
    made = generate("paper-150", np.random.default_rng(0))
    assert len(made) == 150 and len({c.id for c in made}) == 150
    assert {c.location for c in made} == {"NP", "CP", "ND"}
    again = configurations(CP, 40, np.random.default_rng(5))
    assert again == configurations(CP, 40, np.random.default_rng(5))
    assert again[1].lead_mm == 2.5

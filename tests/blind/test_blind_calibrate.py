"""Temperature: recovered from draws whose probabilities are known."""

import numpy as np
import pytest

from sstl_cli.blind.calibrate import Scored, loss, scored, temperature
from sstl_cli.core.errors import SstlError


def library(true_temperature, n=4000, seed=1):
    rng = np.random.default_rng(seed)
    cases = []
    for _ in range(n):
        nats = rng.exponential(3.0 * true_temperature, 6)
        behind = -(nats - nats.min())
        p = np.exp(behind / true_temperature)
        cases.append(Scored(behind, int(rng.choice(6, p=p / p.sum()))))
    return cases


@pytest.mark.parametrize("wanted", [0.7, 4.0, 60.0])
def test_temperature_is_recovered(wanted):
    cases = library(wanted)
    found = temperature(cases)
    assert found == pytest.approx(wanted, rel=0.1)
    assert loss(cases, found) <= loss(cases, wanted) + 1e-9


def test_a_small_library_is_refused():
    with pytest.raises(SstlError, match="E955"):
        temperature(library(1.0, 5))


TRUTH = {"poor": None, "excluded": False, "unlisted": [], "effects": {"b": {}}}
DIAGNOSIS = {
    "base_score": 10.0,
    "candidates": [
        {"id": "a", "score": 30.0},
        {"id": "b", "score": 42.0},
        {"id": "a+b", "score": 50.0},
        {"id": "quantisation", "score": None},
    ],
}


def test_scores_of_single_candidates_and_the_base_are_used():
    found = scored(TRUTH, DIAGNOSIS)
    np.testing.assert_allclose(found.behind, [-32.0, -12.0, 0.0])
    assert found.true == 2
    assert scored({**TRUTH, "effects": {}}, DIAGNOSIS).true == 0


@pytest.mark.parametrize("change", [{"excluded": True}, {"poor": "slow"}, {"unlisted": ["x"]}, {"effects": {"q": {}}}])
def test_cases_without_a_true_candidate_are_left_out(change):
    assert scored({**TRUTH, **change}, DIAGNOSIS) is None


def test_discounted_distances_come_first():
    rows = [{**c, "behind_nats": d} for c, d in zip(DIAGNOSIS["candidates"][:2], (5.0, 0.0), strict=True)]
    found = scored(TRUTH, {**DIAGNOSIS, "candidates": rows, "base_behind_nats": 9.0})
    np.testing.assert_allclose(found.behind, [-9.0, -5.0, 0.0])

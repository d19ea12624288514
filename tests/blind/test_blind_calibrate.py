"""Temperature: recovered from draws whose probabilities are known."""

import numpy as np
import pytest

from sstl_cli.blind.calibrate import Scored, loss, scored, temperature, verdicts
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


def test_shares_of_evidence_are_recovered_and_few_cases_lean_on_their_status():
    rng = np.random.default_rng(3)
    evidence = ["none/quiet"] * 4000 + ["none/near"] * 4000 + ["identified/clear"] * 2
    right = [*(rng.random(4000) < 0.9), *(rng.random(4000) < 0.2), True, True]
    found = verdicts(evidence, right)
    assert found["none/quiet"]["right"] == pytest.approx(0.9, abs=0.02)
    assert found["none/near"]["right"] == pytest.approx(0.2, abs=0.02)
    # two right of two are no certainty
    assert 0.6 < found["identified/clear"]["right"] < 0.9

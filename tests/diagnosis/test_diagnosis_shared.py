"""Noise that a known rig shows on another day: all models have it, so that none buys it with the freedom of its own law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, named, simulator

from sstl_cli.diagnosis.evidence import weigh
from sstl_cli.diagnosis.fit import fit, settle
from sstl_cli.diagnosis.found import NOTHING, Search
from sstl_cli.diagnosis.shared import loosened
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Noise, Sensor

PLAIN = simulator()
QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise({"act": QUIET}, {"act": QUIET}, {"act": 1.0})
SCATTER_N, SLOW_S = 0.3, 5.0
OFFSET = named("zero_offset", "z_out_act_n")


def knowing(left: np.ndarray) -> Simulator:
    """Return a simulator of a rig that is known to scatter slowly by 0.3 N, of which a record leaves this (N)."""
    records = tuple(replace(r, misfit_n=np.full(len(r), SCATTER_N), misfit_s=SLOW_S) for r in PLAIN.problem.records)
    sim = Simulator(replace(PLAIN.problem, records=records), PLAIN.mechanics)
    sim.y = sim.predict(THETA, {}) + left
    return sim


def searched(sim: Simulator) -> Search:
    base = settle(sim, NOISE, fit(sim, made().whiten, NOTHING, THETA, np.zeros(0)))
    single = weigh(sim, settle(sim, NOISE, fit(sim, base.whiten, OFFSET, THETA, np.array([0.5]))), base)
    return Search(sim, NOISE, NOISE, base, {"zero_offset": (single,)}, {})


def restless(seconds: float) -> np.ndarray:
    """Return first-order unrest of the known size, beside the sensor's noise (N)."""
    rng, n = np.random.default_rng(5), len(PLAIN.y)
    kept = np.exp(-PLAIN.problem.records[0].dt_s * PLAIN.problem.records[0].factor / seconds)
    slow = np.empty(n)
    at = 0.0
    for i, kick in enumerate(rng.standard_normal(n)):
        at = kept * at + np.sqrt(1.0 - kept**2) * kick
        slow[i] = at
    return SCATTER_N * slow + NOISE_N * rng.standard_normal(n)


def test_a_rig_that_scatters_as_it_is_known_to_has_no_more_noise():
    found = searched(knowing(restless(SLOW_S)))
    more = loosened(found, 1)
    # a hundredth of one law's response is all that chance finds likelier
    assert more.base.cost == pytest.approx(found.base.cost, abs=2.0)
    assert more.sim.more_n is None or more.sim.more_n.max() < 0.1 * SCATTER_N


def test_what_is_faster_than_known_is_noise_of_all_models():
    rng = np.random.default_rng(6)
    found = searched(knowing(restless(SLOW_S) + 0.1 * SCATTER_N * rng.standard_normal(len(PLAIN.y))))
    more = loosened(found, 1)
    assert more.sim.more_n == pytest.approx(np.full(len(PLAIN.y), 0.1 * SCATTER_N)) and more.sim.slips_n is None
    # without it the base explains the record by noise that is too small, as exp(nats) says
    assert more.base.cost < found.base.cost - 100.0
    assert abs(more.singles["zero_offset"][0].gain) < 5.0


def test_a_change_is_no_less_evident_by_the_noise_of_the_model_that_knows_it():
    left = restless(SLOW_S) + 1.0
    found = searched(knowing(left))
    more = loosened(found, 1)
    best = more.singles["zero_offset"][0]
    assert best.gain > 20.0 and best.fit.values == pytest.approx([1.0], abs=0.5)


def test_a_rig_of_which_nothing_is_known_keeps_its_noise():
    base = made(0.1)
    found = Search(PLAIN, NOISE, NOISE, base, {}, {})
    assert loosened(found, 1) is found


def test_without_candidates_the_base_has_the_noise_as_well():
    rng = np.random.default_rng(6)
    found = searched(knowing(restless(SLOW_S) + 0.1 * SCATTER_N * rng.standard_normal(len(PLAIN.y))))
    more = loosened(replace(found, singles={}), 1)
    assert more.sim.more_n is not None and more.base.cost < found.base.cost - 100.0

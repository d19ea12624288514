"""A zero that drifts as a bridge warms up: the textbook's curve, and the steady drift where it is slow."""

import numpy as np
import pytest

from sstl_cli.physics.effect import Sampling
from sstl_cli.physics.effects import get

RUN, FLAT = Sampling("act", 0.1, 101), np.full(101, 5.0)


def output(**values):
    effect = get("zero_drift")
    return effect.output(FLAT, FLAT, RUN, effect.complete(values)) - FLAT


def test_a_bridge_warms_up_by_its_time_constant():
    # tau 4 s of a run of 10 s; the drift over the run is what the parameter says
    time = np.arange(101) / 10.0
    told = 0.4 * (1.0 - np.exp(-time / 4.0)) / (1.0 - np.exp(-10.0 / 4.0))
    assert output(r_out_act_n=0.4, warming=2.5) == pytest.approx(told, abs=1e-12)


def test_a_slow_warm_up_is_a_steady_drift():
    steady = output(r_out_act_n=0.4)
    assert steady == pytest.approx(0.4 * np.arange(101) / 100.0)
    assert output(r_out_act_n=0.4, warming=1e-6) == pytest.approx(steady, abs=1e-6)


def test_what_the_input_adds_is_taken_off_again():
    effect = get("zero_drift")
    values = effect.complete({"r_in_act_n": -0.3, "warming": 3.0})
    read = effect.input(FLAT, FLAT, RUN, values)
    assert read[-1] == pytest.approx(4.7) and effect.input_inverse(read, FLAT, RUN, values) == pytest.approx(FLAT)


def test_a_zero_warms_up_over_a_session_whatever_run_it_is_read_in():
    effect = get("zero_drift")
    values = effect.complete({"s_out_act_n": 0.4, "session_s": 30.0})
    whole = Sampling("act", 0.1, 601)
    told = 0.4 * (1.0 - np.exp(-np.arange(601) / 300.0))
    for begun in (0, 250, 500):
        run = Sampling("act", 0.1, 101, begun_s=0.1 * begun)
        assert effect.output(FLAT, FLAT, run, values) - FLAT == pytest.approx(told[begun : begun + 101], abs=1e-12)
    assert effect.output(np.zeros(601), np.zeros(601), whole, values) == pytest.approx(told)

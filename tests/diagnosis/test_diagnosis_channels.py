"""Gaps of the channels beside the output: gains by independent samples, the loop's lag, the load's position."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from rig_logs import sound
from scipy.signal import lfilter

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.channels import ChannelGap, _independent, _tracks, log_gain, loop_gaps, position_gaps
from sstl_cli.diagnosis.constants import DECIDES_NATS, JOINS_NATS
from sstl_cli.diagnosis.fit import first_theta, fit
from sstl_cli.diagnosis.found import NOTHING
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import white
from sstl_cli.physics.filters import first_order
from sstl_cli.physics.scenario import Scenario
from sstl_cli.physics.transmission import activate, predict, predict_position
from sstl_cli.physics.transmission.model import drive_of

RNG = np.random.default_rng(3)
WHITE = RNG.standard_normal(20_000)


def test_white_samples_are_all_independent():
    assert _independent(WHITE) == pytest.approx(len(WHITE), rel=0.1)


@pytest.mark.parametrize("memory", [0.5, 0.9])
def test_correlated_samples_count_less(memory):
    # of first-order noise: (1 - memory) / (1 + memory)
    x = lfilter([1.0], [1.0, -memory], WHITE)
    assert _independent(x) == pytest.approx(len(x) * (1.0 - memory) / (1.0 + memory), rel=0.25)


def test_repeated_samples_count_once():
    # the correlation of a reading held for ten samples falls linearly: 1 + 2 (9 + 8 + ... + 1) / 10 = 10 samples say what one does
    assert _independent(np.repeat(WHITE[:2000], 10)) == pytest.approx(2000.0, rel=0.25)


def test_a_residual_that_never_changes_has_no_correlation():
    assert _independent(np.full(50, 3.0)) == 50.0


def test_the_gain_is_that_of_an_unknown_scale():
    # half the error on n independent samples: n log 2 nats
    n = _independent(WHITE)
    gap = np.sqrt(3.0) * np.std(WHITE) * np.tile([1.0, -1.0], len(WHITE) // 2)
    base = WHITE - WHITE.mean() + gap
    assert log_gain(base, WHITE, WHITE) == pytest.approx(n * np.log(2.0), rel=0.02)
    assert log_gain(WHITE, WHITE, WHITE) == 0.0 and log_gain(WHITE, 2.0 * WHITE, WHITE) < 0.0


def test_a_gain_made_where_the_scatter_is_counts_as_few_samples_as_are_there():
    # a clock that jitters: a lag shows on the fast tenth of the record, and so does all of the scatter
    fast = np.where(np.arange(len(WHITE)) % 10 == 0, 1.0, 1e-3)
    left = fast * WHITE
    lag = 0.1 * np.std(WHITE) * fast
    even = 0.5 * _independent(left) * 2.0 * np.log(np.std(left + lag) / np.std(left))
    assert log_gain(left + lag, left, left) == pytest.approx(0.1 * even, rel=0.2)


def test_a_slow_law_error_does_not_make_a_gain_large():
    slow = np.sin(np.arange(2000) / 300.0)
    assert log_gain(2.0 * slow, slow, slow) < 0.05 * log_gain(2.0 * WHITE[:2000], WHITE[:2000], WHITE[:2000])


def test_a_gap_as_a_candidate():
    row = ChannelGap("tension_in", "N", "tension_loop_lag", {"tau_s": 0.1, "inverse_slew_s_per_n": 0.0}, 4.0, 1.0, 0.5, 900.0).row()
    assert (row.ids, row.kind, row.strengths, row.share, row.chi2) == (("tension_loop_lag",), "beside", 2, 0.75, 4.0)
    assert 850.0 < row.evidence < row.gain == 900.0


T = np.arange(0.0, 30.0, 0.02)
REFERENCE = 10.0 + 5.0 * np.sin(2.0 * np.pi * T / 5.0) * (T % 10.0 < 7.0)


def followed(tension, reference=REFERENCE):
    noisy = tension + 0.01 * RNG.standard_normal(len(T))
    return Run("r", "act", T, noisy, 0.6 * noisy, tension_ref_n=reference)


@pytest.mark.parametrize(
    "run, tracks",
    [
        (followed(REFERENCE), True),
        (followed(first_order(REFERENCE, 0.02, 0.1, 0.0)), True),
        # a loop that is slow beside the movement turns late and does not come as far: a correlation of 0.89 and a slope of 0.79 at once
        (followed(first_order(REFERENCE, 0.02, 0.4, 0.0)), True),
        (followed(1.5 * REFERENCE), False),
        (followed(-REFERENCE), False),
        (followed(REFERENCE, np.full(len(T), 10.0)), False),
        (followed(REFERENCE, np.where(np.arange(len(T)) < 99, REFERENCE, np.nan)), False),
        (followed(10.0 + RNG.standard_normal(len(T))), False),
    ],
    ids=["exact", "lagging", "lagging by most of a stroke", "another scale", "another sign", "constant", "hardly any", "unrelated"],
)
def test_a_loop_is_judged_where_the_input_follows_its_reference(run, tracks):
    assert _tracks(run) is tracks


def looped(tension):
    run = followed(tension)
    return loop_gaps([SimpleNamespace(raw=run, faults_in=sound(len(T), 0.01))])


def test_the_lag_of_a_loop_is_found():
    (gap,) = looped(first_order(REFERENCE, 0.02, 0.12, 0.0))
    assert gap.values["tau_s"] == pytest.approx(0.12, rel=0.02) and gap.rmse_with == pytest.approx(0.01, rel=0.1)
    assert gap.row().share > 0.9 and gap.gain > 1000.0


@pytest.mark.parametrize(("tau", "slew"), [(0.05, 0.05), (0.1, 0.1), (0.02, 0.1), (0.05, 0.08), (0.0, 0.05)])
def test_a_lag_and_a_slew_limit_of_one_loop_are_found_together(tau, slew):
    # steps of 3 N on slow ramps: both show
    time = np.arange(0.0, 20.0, 0.005)
    asked = 10.0 + 12.0 * np.abs((0.35 * time) % 2.0 - 1.0) + 3.0 * (np.sin(2.0 * np.pi * 0.8 * time) > 0.0)
    read = first_order(asked, 0.005, tau, slew) + 0.01 * np.random.default_rng(0).standard_normal(len(time))
    run = Run("r", "act", time, read, read, tension_ref_n=asked)
    (gap,) = loop_gaps([SimpleNamespace(raw=run, faults_in=sound(len(time), 0.01))])
    assert gap.rmse_with == pytest.approx(0.01, rel=0.05)
    assert gap.values == pytest.approx({"tau_s": tau, "inverse_slew_s_per_n": slew}, rel=0.05, abs=1e-3)


def test_a_slew_limit_is_found_though_a_faster_one_does_nothing():
    # ramps of 10 N/s in a loop that does 9: below 0.1 s/N nothing shows, and a little beyond 0.111 everything is off
    asked = np.interp(T % 12.0, [0.0, 1.5, 6.0, 7.5, 12.0], [5.0, 20.0, 20.0, 5.0, 5.0])
    run = followed(first_order(asked, 0.02, 0.0, 1.0 / 9.0), asked)
    (gap,) = loop_gaps([SimpleNamespace(raw=run, faults_in=sound(len(T), 0.01))])
    assert gap.values["inverse_slew_s_per_n"] == pytest.approx(1.0 / 9.0, rel=0.01) and gap.rmse_with == pytest.approx(0.01, rel=0.1)


def test_what_was_not_recorded_says_nothing_of_the_loop():
    run = followed(first_order(REFERENCE, 0.02, 0.12, 0.05))
    gap = (T % 11.0 > 2.0) & (T % 11.0 < 4.0)
    bridged = np.interp(T, T[~gap], run.tension_in_n[~gap])
    broken = replace(run, tension_in_n=bridged, tension_ref_n=np.where(gap, np.nan, REFERENCE), extra={"gap": gap.astype(float)})
    (found,) = loop_gaps([SimpleNamespace(raw=broken, faults_in=sound(len(T), 0.01))])
    assert found.rmse_with == pytest.approx(0.01, rel=0.1)
    assert found.values == pytest.approx({"tau_s": 0.12, "inverse_slew_s_per_n": 0.05}, rel=0.05)


def test_the_lag_that_a_simulator_has_is_no_gap_and_another_one_is_a_change_of_it():
    run = followed(first_order(REFERENCE, 0.02, 0.12, 0.0))
    records = [SimpleNamespace(raw=run, faults_in=sound(len(T), 0.01))]
    (same,) = loop_gaps(records, {"tau_s": 0.12, "inverse_slew_s_per_n": 0.0})
    assert same.rmse_base == pytest.approx(0.01, rel=0.1) and same.row().share < 0.01 and same.row().evidence < 0.0
    (other,) = loop_gaps(records, {"tau_s": 0.06, "inverse_slew_s_per_n": 0.0})
    assert other.values["tau_s"] == pytest.approx(0.12, rel=0.02) and other.row().share > 0.9


def test_a_loop_without_a_lag_gains_nothing():
    (gap,) = looped(REFERENCE)
    assert gap.row().share < 0.01 and gap.row().evidence < 0.0


def test_without_a_reference_there_is_no_loop():
    assert loop_gaps([SimpleNamespace(raw=Run("r", "act", T, REFERENCE, REFERENCE), faults_in=None)]) == []


def positioned(effects, sensor=lambda y: y, load=lambda tension: tension / 8.0, per_kn=0.0, claimed=None):
    """Return the gaps of the position of a line with a load, judged by a base that knows what is claimed of it alone."""
    mechanics = Scenario().rig.mechanics()
    runs = []
    for i, period in enumerate((5.0, 9.0)):
        u = 12.0 + 9.0 * np.sin(2.0 * np.pi * T / period)
        out = predict(drive_of("act", None, 0.02, u, mechanics), 0.5, activate(effects))
        noise = RNG.standard_normal((3, len(T)))
        read, seen = u + 0.01 * noise[0], sensor(out) + 0.01 * noise[1]
        drive = drive_of("act", None, 0.02, u, mechanics)
        line = activate({"tendon_elasticity": {"compliance_per_kn": per_kn}})
        stretched = predict_position(drive, 0.5, line, out) - predict_position(drive, 0.5, activate({}), out)
        runs.append(Run(f"r{i}", "act", T, read, seen, config_id="a", position_in_mm=3.0 + load(out) + stretched + 0.002 * noise[2]))
    sim = Simulator(prepare(runs), mechanics, claimed or {})
    plain = white(1.0, sim.weight, [s.start for s in sim.slices()])
    base = fit(sim, plain, NOTHING, first_theta(sim, np.array([0.5])), np.zeros(0))
    return {g.effect: g for g in position_gaps(sim, base, ["load_spring", "tendon_elasticity", "zero_offset"])}


@pytest.mark.parametrize(
    "effects, sensor",
    [({}, lambda y: y), ({}, lambda y: y + 0.8), ({}, lambda y: 1.15 * y), ({"const_friction": {"w_l_n": 0.8}}, lambda y: y)],
    ids=["nothing", "offset of the output", "gain of the output", "friction along the line"],
)
def test_an_effect_of_the_output_makes_no_load_that_is_no_spring(effects, sensor):
    gap = positioned(effects, sensor)["load_spring"]
    assert gap.row().share < 0.05 and gap.row().evidence < JOINS_NATS


def test_a_load_that_stiffens_is_found_whatever_the_output():
    def stiffening(tension):
        x = np.linspace(0.0, 5.0, 2000)
        return np.interp(tension, 8.0 * (x + 0.02 * x**3), x)

    gap = positioned({}, lambda y: y + 0.8, stiffening)["load_spring"]
    assert gap.row().share > 0.5 and gap.row().evidence > 100.0


def test_an_elasticity_that_a_simulator_has_may_have_changed():
    """What beside the output was in the model could not be asked for: a tendon thirty times as soft was `none`."""
    known = {"tendon_elasticity": {"compliance_per_kn": 0.001}}
    assert positioned({}, per_kn=0.001, claimed=known)["tendon_elasticity"].row().share < 0.05
    softer = positioned({}, per_kn=0.03, claimed=known)["tendon_elasticity"]
    assert softer.row().share > 0.9 and softer.row().evidence > 100.0
    assert softer.values["compliance_per_kn"] == pytest.approx(0.03, rel=0.05)


def test_a_claim_that_is_off_by_as_much_as_laws_are_has_not_changed():
    """Another simulator's tendon looked 6 % softer at 200 nats, and was named."""
    known = {"tendon_elasticity": {"compliance_per_kn": 0.03}}
    slightly, truly = (positioned({}, per_kn=c, claimed=known)["tendon_elasticity"] for c in (0.0315, 0.039))
    assert slightly.gain > 50.0 and slightly.row().evidence < DECIDES_NATS
    assert slightly.moved == pytest.approx(0.05, rel=0.2)
    assert truly.row().evidence > JOINS_NATS


def test_without_a_position_or_an_effect_of_it_there_is_no_gap():
    u = 12.0 + 9.0 * np.sin(2.0 * np.pi * T / 5.0) + 0.01 * RNG.standard_normal(len(T))
    sim = Simulator(prepare([Run("r", "act", T, u, 0.6 * u)]), Scenario().rig.mechanics())
    assert position_gaps(sim, None, ["load_spring"]) == [] and position_gaps(sim, None, ["zero_offset"]) == []

"""The fast model on records: the play of Eq. (3) and (5) in plain Python, means of blocks, phases, sensors, starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import THETA, simulator

from sstl_cli.diagnosis import simulator as simulator_of
from sstl_cli.diagnosis.drives import neighbour_of
from sstl_cli.diagnosis.ending import held_back, parted
from sstl_cli.diagnosis.records import Start
from sstl_cli.diagnosis.simulator import CEILING_N, Simulator, _means
from sstl_cli.diagnosis.wander import nowhere
from sstl_cli.diagnosis.whitening import Noise, Sensor

SIM = simulator()
GAIN = {"gain_error": {"g_act": 1.1}}
ZEROS = {"z_in_act_n": 0.0, "z_out_act_n": 0.0}
NOISE = Noise({"act": Sensor(0.01, 0.03, 0.1)}, {"act": Sensor(0.01, 0.0, 0.1)}, {"act": 2.0})


def played(u, theta, start):
    """Return the output of a play between the two propagation lines of one pass."""
    out, last = np.empty(len(u)), start
    for k, x in enumerate(u):
        last = out[k] = min(max(last, np.exp(-theta) * x), np.exp(theta) * x)
    return out


def expected(of=lambda r, theta: played(r.u, theta, r.start_n)):
    return np.concatenate([of(r, THETA[r.config]) for r in SIM.problem.records])


def changed(**fields):
    """Return the simulator with fields of all its records changed."""
    records = tuple(replace(r, **{k: v(r) for k, v in fields.items()}) for r in SIM.problem.records)
    return replace(SIM, problem=replace(SIM.problem, records=records))


def test_models_simulated_together_are_those_simulated_alone():
    models = [
        (THETA, {}), (1.1 * THETA, {"presliding": {"breakaway_mm": 0.2}, "line": {"load_mm_per_n": 0.3}}),
        (THETA, {"viscous": {"c_l_n_s_per_mm": 0.01}, "zero_offset": {"z_in_act_n": 0.1}}), (THETA, {"friction_drift": {"d_mu": 0.2}, "stribeck": {"ratio": 1.1}}),
    ]  # fmt: skip
    for (theta, effects), together in zip(models, SIM.predict_each(models), strict=True):
        assert (SIM.predict(theta, effects) == together).all()


def test_a_line_is_a_play_between_its_two_slopes():
    assert SIM.predict(THETA, {}) == pytest.approx(expected(), abs=1e-9)
    fine = SIM.predict_fine(THETA, {})
    assert len(fine) == 4 and np.concatenate(fine) == pytest.approx(SIM.predict(THETA, {}))


def test_samples_know_their_record_and_its_configuration():
    counts = [len(r) for r in SIM.problem.records]
    assert [s.stop - s.start for s in SIM.slices()] == counts and SIM.slices()[1].start == counts[0]
    assert np.array_equal(SIM.run, np.repeat(range(4), counts)) and np.array_equal(SIM.config, np.repeat([0, 1, 0, 1], counts))


def test_the_output_s_sensor_reads_what_the_line_does_and_its_start_is_undone():
    # the record begins with what was read
    for g in (0.125, 1.1):
        gain = {"gain_error": {"g_act": g}}
        assert SIM.predict(THETA, gain) == pytest.approx(expected(lambda r, a, g=g: g * played(r.u, a, r.start_n / g)), abs=1e-9)
    zero = {"zero_offset": {**ZEROS, "z_out_act_n": 0.4}}
    assert SIM.predict(THETA, zero) == pytest.approx(expected(lambda r, a: 0.4 + played(r.u, a, r.start_n - 0.4)), abs=1e-9)


def test_a_gain_leaves_an_output_in_another_unit_where_it_reads_nothing():
    other = replace(SIM, zeros_n={"act": -2.0})
    assert other.predict(THETA, GAIN) == pytest.approx(
        expected(lambda r, a: 1.1 * (2.0 + played(r.u, a, (r.start_n + 2.0) / 1.1 - 2.0)) - 2.0), abs=1e-9
    )


def test_the_input_s_sensor_is_undone_before_the_line():
    zero = {"zero_offset": {**ZEROS, "z_in_act_n": 0.5}}
    assert SIM.predict(THETA, zero) == pytest.approx(expected(lambda r, a: played(r.u - 0.5, a, r.start_n)), abs=1e-9)


def test_what_is_known_to_be_left_is_read_by_the_sensor_like_the_rest():
    knowing = changed(known=lambda r: np.linspace(0.0, 1.0, len(r.u)))
    more = np.concatenate([np.linspace(0.0, 1.0, len(r)) for r in SIM.problem.records])
    assert knowing.predict(THETA, {}) == pytest.approx(SIM.predict(THETA, {}) + more)
    assert knowing.predict(THETA, GAIN) == pytest.approx(SIM.predict(THETA, GAIN) + 1.1 * more)
    # but it moves no phase
    assert np.array_equal(knowing.phases(THETA, {}).gain, SIM.phases(THETA, {}).gain)
    # of records of which nothing is known it is nothing
    first, *rest = SIM.problem.records
    some = replace(SIM, problem=replace(SIM.problem, records=(first, *(replace(r, known=np.ones(len(r.u))) for r in rest))))
    assert some.predict(THETA, {}) - SIM.predict(THETA, {}) == pytest.approx((SIM.run > 0).astype(float))


def test_more_friction_at_the_end_holds_back_what_is_known_to_be_left_too():
    seal = {"const_friction": {"w_end_n": 0.4}}
    # where nothing is known the line has it: a play behind a play is one between lines that are so much farther apart
    plays = expected(lambda r, a: held_back(played(r.u, a, r.start_n), 0.4, np.array([0]), np.array([r.start_n])))
    assert SIM.predict(THETA, seal) == pytest.approx(plays, abs=1e-9)
    knowing = changed(known=lambda r: np.sin(np.arange(len(r.u))))
    whole = expected(
        lambda r, a: held_back(played(r.u, a, r.start_n) + np.sin(np.arange(len(r.u))), 0.4, np.array([0]), np.array([r.start_n]))
    )
    assert knowing.predict(THETA, seal) == pytest.approx(whole, abs=1e-9)
    # what an accepted model has of it is its line's, and so is all that is accepted from now on
    ripple = np.concatenate([np.sin(np.arange(len(r))) for r in SIM.problem.records])
    assert replace(knowing, fixed=seal).predict(THETA, {}) == pytest.approx(SIM.predict(THETA, seal) + ripple, abs=1e-9)
    assert replace(knowing, behind=False).predict(THETA, seal) == pytest.approx(SIM.predict(THETA, seal) + ripple, abs=1e-9)


def test_a_sticky_sensor_is_friction_at_the_end_to_any_recording():
    sticky = SIM.predict(THETA, {"sensor_nonlinearity": {"h_n": 0.4}})
    assert sticky == pytest.approx(SIM.predict(THETA, {"const_friction": {"w_end_n": 0.4}}), abs=1e-9)
    assert np.abs(sticky - SIM.predict(THETA, {})).max() > 0.3


def test_friction_begins_anew_where_a_record_does_and_as_it_arrives_where_nothing_was_read():
    arriving = np.array([0.0, 1.0, 2.0, 1.0, -1.0, 5.0, 5.0])
    assert held_back(arriving, 0.5, np.array([0, 5]), np.array([0.2, np.nan])).tolist() == [0.2, 0.5, 1.5, 1.5, -0.5, 5.0, 5.0]
    values, fixed = {"const_friction": {"w_l_n": 0.1, "w_end_n": 0.3}}, {"const_friction": {"w_end_n": 0.2}}
    effects, more = parted(values, fixed)
    assert effects["const_friction"] == {"w_l_n": 0.1, "w_end_n": 0.2} and more == pytest.approx(0.1)
    assert parted(fixed, values) == (fixed, 0.0) and parted({}, fixed) == ({}, 0.0)


def test_an_effect_that_the_simulator_contains_is_changed_by_the_candidate():
    fixed = replace(SIM, fixed={"gain_error": {"g_act": 1.1}, "stribeck": {"ratio": 1.2, "v_s_mm_s": 3.0}})
    assert SIM.changed("gain_error", {"g_act": 1.05}) == {"g_act": 1.05}
    assert fixed.changed("gain_error", {"g_act": 1.05})["g_act"] == pytest.approx(1.15)
    # a shape stays what it is, and nothing leaves its meaning
    both = fixed.changed("stribeck", {"ratio": 1.1, "v_s_mm_s": 9.0})
    assert both["ratio"] == pytest.approx(1.3) and both["v_s_mm_s"] == 3.0
    assert fixed.changed("stribeck", {"ratio": 1e6})["ratio"] == 15.0
    fixed = replace(SIM, fixed=GAIN)
    assert fixed.predict(THETA, {}) == pytest.approx(SIM.predict(THETA, GAIN))
    assert fixed.predict(THETA, {"gain_error": {"g_act": 1.1}}) == pytest.approx(SIM.predict(THETA, {"gain_error": {"g_act": 1.2}}))


def test_a_model_begins_anew_where_the_input_may_have_turned_unseen():
    again = changed(again=lambda r: (Start(700, 9.0, 0.1),))
    halves = expected(lambda r, a: np.concatenate((played(r.u[:700], a, r.start_n), played(r.u[700:], a, 9.0))))
    assert again.predict(THETA, {}) == pytest.approx(halves, abs=1e-9)
    read = expected(lambda r, a: 1.1 * np.concatenate((played(r.u[:700], a, r.start_n / 1.1), played(r.u[700:], a, 9.0 / 1.1))))
    assert again.predict(THETA, GAIN) == pytest.approx(read, abs=1e-9)


def test_the_load_of_an_elastic_line_is_that_of_the_rig_unless_it_is_given():
    elastic = {"presliding": {"breakaway_mm": 0.3, "spread": 0.5}}
    as_built = SIM.predict(THETA, {**elastic, "line": {"load_mm_per_n": SIM.mechanics.end_mm_per_n("act")}})
    assert as_built == pytest.approx(SIM.predict(THETA, elastic))
    assert np.abs(SIM.predict(THETA, {**elastic, "line": {"load_mm_per_n": 0.5}}) - as_built).max() > 0.01


def test_means_count_each_sample_by_its_share_and_only_numbers():
    fine = np.array([1.0, 3.0, 2.0, np.nan, -np.inf, 5.0, 7.0])
    share = np.array([0.5, 0.5, 1.0, 0.0, 1.0, 0.25, 0.75])
    out = _means(fine, share, np.array([0, 4, 7]), np.array([0, 2, 5]), np.array([2, 1]))
    assert out.tolist() == [2.0, 2.0, -CEILING_N, 1.25, 5.25]
    assert _means(np.array([np.nan, 1e9]), np.ones(2), np.array([0, 2]), np.array([0, 2]), np.array([1])).tolist() == [CEILING_N] * 2


def test_a_play_slides_along_its_slopes_and_is_in_doubt_near_them():
    phases = SIM.phases(THETA, {})
    clear = phases.doubt_n < 1e-9
    on = (np.isclose(SIM.predict(THETA, {}), expected(lambda r, a, s=s: np.exp(s * a) * r.u)) for s in (-1.0, 1.0))
    # within a slide, not where it begins
    pulls, releases = (x & np.roll(x, 1) for x in on)
    assert phases.gain[pulls & clear] == pytest.approx(np.exp(-THETA[SIM.config[pulls & clear]]), rel=1e-6)
    assert phases.gain[releases & clear] == pytest.approx(np.exp(THETA[SIM.config[releases & clear]]), rel=1e-6)
    assert np.mean(np.isclose(phases.slide[(pulls | releases) & clear], 1.0)) > 0.99 and 0 < np.sum(~clear) < 0.1 * len(clear)
    # a hold keeps what the slide before it has left
    held = ~pulls & ~releases & clear
    assert np.mean(phases.slide[held] == 0.0) > 0.95
    slopes = np.exp(np.outer([-1.0, 1.0], THETA[SIM.config[held]]))
    assert np.mean(np.isclose(phases.gain[held], slopes).any(axis=0) | (phases.gain[held] == 0.0)) > 0.9
    # an input that is known worse leaves more in doubt
    assert SIM.phases(THETA, {}, NOISE).doubt_n.sum() > 2.0 * phases.doubt_n.sum()


def test_noise_enters_by_the_phases_of_an_accepted_model_whatever_is_fitted():
    assert np.array_equal(SIM.where_noise_enters(THETA, {}, NOISE).gain, SIM.phases(THETA, {}, NOISE).gain)
    accepted = replace(SIM, accepted=THETA)
    kept = accepted.where_noise_enters(2.0 * THETA, GAIN, NOISE)
    assert np.array_equal(kept.gain, SIM.phases(THETA, {}, NOISE).gain) and accepted.where_noise_enters(THETA, {}, NOISE) is kept
    assert accepted.where_noise_enters(THETA, {}, replace(NOISE)) is not kept


def test_known_scatter_is_read_late_by_a_late_sensor():
    known = changed(
        misfit_n=lambda r: np.arange(len(r), dtype=float),
        misfit_s=lambda r: 0.1 + np.arange(len(r)),
        wander=lambda r: replace(nowhere(len(r)), stretch=np.arange(len(r))[:, None] * 1.0, stretches=(slice(0, len(r)),)),
    )
    r = known.problem.records[0]
    (late, *_) = known.read_records({"channel_delay": {"tau_act_s": 3.0 * r.dt_s * r.factor}})
    assert late.misfit_s[3:] == pytest.approx(r.misfit_s[:-3])
    assert late.misfit_n[3:] == pytest.approx(r.misfit_n[:-3]) and late.wander.stretch[3:] == pytest.approx(r.wander.stretch[:-3])
    assert known.read_records({})[0] is r
    # a step of the analysis is as many of the simulation's as the factor says
    coarse = simulator_of._read_late(replace(r, factor=2), 6.0 * r.dt_s)
    assert coarse.misfit_n[3:] == pytest.approx(r.misfit_n[:-3]) and coarse.misfit_s[3:] == pytest.approx(r.misfit_s[:-3])
    (none, *_) = SIM.read_records({"channel_delay": {"tau_act_s": 0.1}})
    assert none.misfit_n is None and none.wander is None


def test_tendons_beside_are_averaged_to_the_grid_of_the_simulation():
    r = SIM.problem.records[0]
    assert neighbour_of(r) is None
    beside = replace(r, dt_s=2.0 * r.raw.dt_s, u=r.u[:5], raw=replace(r.raw, extra={"neighbour_n": np.arange(len(r.raw), dtype=float)}))
    assert neighbour_of(beside).tolist() == [0.5, 2.5, 4.5, 6.5, 8.5]


def test_records_without_scatter_make_one_simulator_of_each_size():
    one = Simulator(replace(SIM.problem, records=SIM.problem.records[:1]), SIM.mechanics)
    assert one.predict(THETA, {}) == pytest.approx(SIM.predict(THETA, {})[SIM.slices()[0]])

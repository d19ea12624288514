"""Along which ways a rig varies, on the small made records against linear algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, THETA, made, noise, simulator

from sstl_cli.diagnosis import variation
from sstl_cli.diagnosis.constants import PARAMETER_STEP, THETA_STEP
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.diagnosis.variation import Ways, applied, directions, learned, of_the_whole, rescaled, ways
from sstl_cli.diagnosis.whitening import white
from sstl_cli.physics.scenario import Variation, WanderSection

SIM = simulator()
OUT = ("zero_offset", "z_out_act_n")
GAIN = ("gain_error", "g_act")
SHAPED = {"zero_offset": {}, "gain_error": {}, "stribeck": {"mean_mm_s": 2.0}}
QUIET = white(NOISE_N, SIM.weight, [s.start for s in SIM.slices()])


def named(effect_id, *names):
    """Return the hypothesis of an effect with just these parameters free."""
    return next(h for h in variants(effect_id, ("act",)) if [f.parameter.name for f in h.free] == list(names))


def model(h, *values):
    return Weighed(made(0.0, h, values), 0.0, 0.0)


def test_ways_are_the_strengths_that_were_fitted_the_most_evident_model_first():
    both = full("zero_offset", ("act",))
    slow = named("stribeck", "mean_ratio", "mean_mm_s")
    own = ways(
        [(model(named(*OUT), 0.3), model(both, 0.1, 0.2)), (model(slow, 1.25, 2.0), model(slow, 1.5, 3.0)), (model(named(*GAIN), 1.1),)]
    )
    assert own.strengths == (OUT, ("zero_offset", "z_in_act_n"), ("stribeck", "mean_ratio"), GAIN)
    # from neutral, which is 1 for a ratio
    assert own.steps == pytest.approx((0.3, 0.1, 0.25, 0.1)) and own.shapes == SHAPED


def test_the_load_of_the_line_is_no_way_to_vary():
    own = ways([(model(variants("presliding", ("act",))[0], 0.2, 0.4, 0.1),)])
    assert own.strengths == (("presliding", "breakaway_mm"),) and own.shapes == {"presliding": {"spread": 0.4}}


def test_what_varies_is_kept_with_the_shapes_that_it_was_seen_at():
    own = Ways((OUT, ("stribeck", "mean_ratio"), GAIN), (0.1, 0.2, 0.1), SHAPED)
    kept = own.section(np.array([0.01, 0.5, 0.2, 0.0]))
    assert kept == Variation(theta=0.01, effects={"zero_offset": {"z_out_act_n": 0.5}, "stribeck": {"mean_mm_s": 2.0, "mean_ratio": 0.2}})
    assert own.section(np.array([0.0, 0.0, 0.2, 0.3])).effects == {
        "stribeck": {"mean_mm_s": 2.0, "mean_ratio": 0.2},
        "gain_error": {"g_act": 0.3},
    }


def test_directions_are_differences_of_predictions():
    friction = ("const_friction", "w_l_n")
    own = Ways((GAIN, friction), (0.1, 0.2), {"gain_error": {}, "const_friction": {}})
    columns = directions(SIM, THETA, {}, own)
    base = SIM.predict(THETA, {})
    assert columns[:, 0] == pytest.approx((SIM.predict(THETA + THETA_STEP, {}) - base) / THETA_STEP)
    for i, (effect_id, name, at, far) in enumerate([(*GAIN, 1.1, 0.1), (*friction, 0.2, 0.2)], 1):
        assert columns[:, i] == pytest.approx((SIM.predict(THETA, {effect_id: {name: at}}) - base) / far)


@pytest.mark.parametrize(("far", "moved"), [(0.0, 0.5 * PARAMETER_STEP), (-0.3, 0.5 * PARAMETER_STEP), (99.0, 5.0)])
def test_a_step_is_one_that_can_be_seen_and_that_the_effect_can_make(far, moved):
    # from 0 upwards, to 10 times the usual 0.5 N
    columns = directions(SIM, THETA, {}, Ways((("const_friction", "w_l_n"),), (far,), {"const_friction": {}}))
    expected = (SIM.predict(THETA, {"const_friction": {"w_l_n": moved}}) - SIM.predict(THETA, {})) / moved
    assert columns[:, 1] == pytest.approx(expected, abs=1e-6)


def test_an_effect_that_is_there_is_moved_from_where_it_is():
    present = {"gain_error": {"g_act": 1.05}, "const_friction": {"w_l_n": 0.1}}
    columns = directions(SIM, THETA, present, Ways((GAIN,), (0.1,), {"gain_error": {}}))
    ends = [SIM.predict(THETA, {**present, "gain_error": {"g_act": g}}) for g in (1.05, 1.15)]
    assert columns[:, 1] == pytest.approx((ends[1] - ends[0]) / 0.1)
    # at its end it can only come back
    high = {"asymmetric_friction": {"a": 0.9}}
    columns = directions(SIM, THETA, high, Ways((("asymmetric_friction", "a"),), (0.0,), {"asymmetric_friction": {}}))
    less = 0.4 * PARAMETER_STEP
    assert columns[:, 1] == pytest.approx(
        (SIM.predict(THETA, high) - SIM.predict(THETA, {"asymmetric_friction": {"a": 0.9 - less}})) / less, abs=1e-6
    )


def test_sections_are_kept_in_the_units_of_the_recording():
    part = Variation(
        theta=0.1,
        effects={"zero_offset": {"z_out_act_n": 0.2}, "gain_error": {"g_act": 0.3}, "tendon_elasticity": {"compliance_per_kn": 0.4}},
    )
    there = rescaled(WanderSection(stretch_s=5.0, stretch=part, run=part), 10.0)
    assert there.stretch_s == 5.0 and there.stretch == there.run and there.whole == Variation()
    assert there.stretch.theta == 0.1 and there.stretch.effects["gain_error"] == {"g_act": 0.3}
    assert there.run.effects["zero_offset"]["z_out_act_n"] == pytest.approx(2.0)
    assert there.run.effects["tendon_elasticity"]["compliance_per_kn"] == pytest.approx(0.04)


def test_records_know_one_standard_deviation_of_each_way():
    slow = {"mean_mm_s": 2.0, "mean_ratio": 0.2}
    section = WanderSection(
        stretch_s=10.0, stretch=Variation(theta=0.01), run=Variation(effects={"zero_offset": {"z_out_act_n": 3.0}, "stribeck": slow})
    )
    known = applied(SIM, THETA, section, 10.0)
    own = Ways((OUT, ("stribeck", "mean_ratio")), (0.3, 0.2), SHAPED)
    columns = directions(SIM, THETA, {}, own)
    for r, s in zip(known.problem.records, SIM.slices(), strict=True):
        assert r.wander.stretches == tuple(slice(a, a + 500) for a in (0, 500, 1000, 1500))
        assert r.wander.stretch == pytest.approx(columns[s, :1] * 0.01) and r.wander.whole.shape == (2000, 0)
        # 3 units of the recording are 0.3 N
        assert r.wander.run == pytest.approx(columns[s] * np.array([0.0, 0.3, 0.2]))
    assert applied(SIM, THETA, None, 10.0) is SIM


def fitted(residual, whiten=QUIET):
    return replace(made(), residual=residual, whiten=whiten)


def test_what_a_record_varies_by_is_found_where_it_varies():
    own = Ways((OUT,), (0.1,), {"zero_offset": {}})
    offset = directions(SIM, THETA, {}, own)[:, 1]
    rng = np.random.default_rng(4)
    each = 0.2 * rng.standard_normal(16)
    found = learned(SIM, fitted(noise(2) + offset * np.repeat(each, 500)), own)
    # an eighth of 40 s, but no shorter than a loop: of the turns 11, 7, 8 and 6 are over before the end
    assert found.stretch_s == pytest.approx(np.median([80.0 / 11.0, 80.0 / 7.0, 80.0 / 8.0, 80.0 / 6.0]))
    assert found.whole == found.run == Variation() and found.stretch.theta < 0.01
    assert found.stretch.effects["zero_offset"]["z_out_act_n"] == pytest.approx(np.sqrt(np.mean(each**2)), rel=0.1)


def test_what_is_alike_within_a_run_but_not_between_runs_varies_from_run_to_run():
    own = Ways((OUT,), (0.1,), {"zero_offset": {}})
    offset = directions(SIM, THETA, {}, own)[:, 1]
    loud = white(3.0, SIM.weight, [s.start for s in SIM.slices()])
    found = learned(SIM, fitted(offset * np.array([0.14, -0.15, 0.16, -0.14])[SIM.run], loud), own)
    assert found.stretch.effects == {} and found.stretch.theta == 0.0
    # 3 N of noise tell a run to 3 / sqrt(2000) N, a stretch to twice that, as much as is there; what is seen has both in it,
    # and of four runs that far apart nobody doubts it (49 to 1)
    assert found.run.effects["zero_offset"]["z_out_act_n"] == pytest.approx(np.sqrt(0.1477**2 - 9.0 / 2000.0), rel=0.1)


def test_a_stretch_is_an_eighth_of_a_record_but_no_shorter_than_a_loop():
    def record(turns, n=800):
        corners = np.arange(turns + 2.0)
        u = np.interp(np.linspace(0.0, turns + 1.0, n), corners, corners % 2)
        return replace(SIM.problem.records[0], u=u, y=np.zeros(n))

    # 16 s: two seconds, or two turns of fewer than sixteen; what turns once or never is one stretch of twice its length
    found = [variation._stretch_s(record(k)) for k in (40, 16, 8, 2, 1, 0)]
    assert found == pytest.approx([2.0, 2.0, 4.0, 16.0, 32.0, 32.0])


def test_nothing_varies_where_only_noise_is_left():
    own = Ways((OUT, GAIN), (0.1, 0.05), {"zero_offset": {}, "gain_error": {}})
    found = learned(SIM, fitted(noise(3)), own)
    for part in (found.stretch, found.run):
        assert part.theta < 0.005 and all(v < 0.02 for e in part.effects.values() for v in e.values())


def test_as_a_whole_a_model_seems_another_one_by_what_theta_cannot_take_up():
    own = Ways((OUT,), (0.1,), {"zero_offset": {}})
    base = made()
    columns = directions(SIM, THETA, {}, own)
    left = columns[:, 1] - columns[:, 0] * np.array([0.02, -0.03])[SIM.config]
    found = of_the_whole(SIM, replace(base, residual=0.25 * left), own)
    dense = np.zeros((len(SIM.y), 2))
    dense[np.arange(len(SIM.y)), SIM.config] = base.jacobian[:, 0]
    x = columns[:, 1] / NOISE_N
    outside = x - dense @ np.linalg.lstsq(dense, x, rcond=None)[0]
    # one draw: its variance is its square, but for a tenth of what noise alone makes
    assert found.theta == 0.0
    size = found.effects["zero_offset"]["z_out_act_n"]
    score = float(outside @ (0.25 * left / NOISE_N)) / float(outside @ outside)
    assert size == pytest.approx(abs(score), rel=0.15)
    # what theta takes up is no variation
    assert of_the_whole(SIM, replace(base, residual=base.jacobian[:, 0] * 0.01), own).effects == {}


def test_what_is_evident_on_the_own_record_is_usual_as_large_as_it_is_seen():
    slow = named("stribeck", "mean_ratio", "mean_mm_s")
    models = [
        Weighed(made(0.0, named(*OUT), (-0.3,)), 40.0, 40.0),
        Weighed(made(0.0, slow, (1.25, 2.5)), 10.0, 10.0),
        # not evident: not seen
        Weighed(made(0.0, named(*GAIN), (1.1,)), -1.0, -1.0),
    ]
    known = Variation(theta=0.1, effects={"zero_offset": {"z_out_act_n": 0.1, "z_in_act_n": 0.2}})
    found = variation.seen_in(known, models)
    assert found.theta == 0.1 and found.effects == {
        "zero_offset": {"z_out_act_n": pytest.approx(0.3), "z_in_act_n": 0.2},
        "stribeck": {"mean_ratio": pytest.approx(0.25), "mean_mm_s": 2.5},
    }
    assert variation.seen_in(found, models[:1]).effects["zero_offset"]["z_out_act_n"] == pytest.approx(0.3)

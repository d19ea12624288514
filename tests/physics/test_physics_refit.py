"""Simulated, then fitted: the truth comes back, from the fast model itself and from the rig; batched equals single."""

from __future__ import annotations

import numpy as np
import pytest
from physics_refits import table
from soon import asked

from sstl_cli.diagnosis.records import Problem, prepare
from sstl_cli.diagnosis.shrink import parameter_intervals
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.effects import catalogue, typical

TABLE = table()
FITTED = [e.id for e in catalogue().values() if e.fitted and e.channel == "out"]
# friction that weakens with speed makes the line jump: only its own simulator can be asked for it back
JUMPS = ("stribeck", "stick_slip")
# what the fast model and the rig may differ by, as a share of a parameter's range, beside the confidence interval:
# a few mN of difference are many standard errors of a long record
MODEL_SHARE = 0.02
DIFFERS = {
    # 6 bend nodes against 30 carry the spread of the break-away distances
    ("presliding", "breakaway_mm"): 0.03,
    ("presliding", "spread"): 1.0,
    # how far the creep has come at the first sample
    ("viscoelastic_creep", "fraction"): 0.1,
    ("viscoelastic_creep", "tau_s"): 0.05,
}
# what input noise of 10 mN does beyond the interval, as a share of the range: the smoothed input rounds corners, the
# curvatures of the two sensors nearly cancel, and the sensor's play follows the noise; without noise all come
# back from the fast model exactly
NOISE_SHARE = {
    ("dwell_aging", "b"): 0.2,
    ("dwell_aging", "t0_s"): 0.2,
    ("sensor_nonlinearity", "a_in"): 0.15,
    ("sensor_nonlinearity", "a_out"): 0.15,
    ("sensor_nonlinearity", "h_n"): 0.2,
}
# every effect is asked for back in every run of the suite, by the simulator that tells more or costs less; the rest of both is slow:
# of the rig friction of four kinds, bend, creep, play, drift, lag and coupling
OF_RIG = (
    "asymmetric_friction", "channel_lowpass", "const_friction", "crosstalk", "friction_drift", "presliding", "sheath_compliance",
    "viscoelastic_creep", "zero_drift",
)  # fmt: skip
OF_MODEL = tuple(i for i in FITTED if i not in OF_RIG)
# at the strength of the table the line jumps even in the fast model and the fit ends in a side minimum
SMOOTH = {"stribeck": {"ratio": 1.02, "v_s_mm_s": 10.0}}


def strengths(effect_id):
    return TABLE.CASES.get(effect_id) or typical(catalogue()[effect_id])


def estimates(effect_id, simulator, seed, values=None):
    runs = TABLE.simulate.run(TABLE.scenario(simulator, 0.01, 50.0), {effect_id: values or strengths(effect_id)}, seed)
    done = TABLE.refit(effect_id, list(runs))
    return done, parameter_intervals(done.sim, done.fit)


@pytest.mark.parametrize("effect_id", asked(FITTED, *OF_MODEL))
def test_what_the_fast_model_made_comes_back(effect_id):
    values = SMOOTH.get(effect_id) or strengths(effect_id)
    done, intervals = estimates(effect_id, "transmission", 5, values)
    truth = catalogue()[effect_id].complete(values)
    for f, interval in zip(done.free, intervals, strict=True):
        # 95 % interval widened to 99.9 %: some forty parameters are asked; smoothing of the input costs the rest
        share = NOISE_SHARE.get((effect_id, f.parameter.name), 0.01)
        half = 1.7 * (interval.high - interval.estimate) + share * f.width
        assert abs(interval.estimate - truth[f.parameter.name]) <= half, f.parameter.name


@pytest.mark.parametrize("effect_id", asked([i for i in FITTED if i not in JUMPS], *OF_RIG))
def test_what_the_rig_made_comes_back(effect_id):
    done, intervals = estimates(effect_id, "rig", 3)
    truth = catalogue()[effect_id].complete(strengths(effect_id))
    for f, interval in zip(done.free, intervals, strict=True):
        name = f.parameter.name
        share = max(DIFFERS.get((effect_id, name), MODEL_SHARE), NOISE_SHARE.get((effect_id, name), 0.0))
        half = (interval.high - interval.estimate) + share * f.width
        assert abs(interval.estimate - truth[name]) <= half, name
        if not f.parameter.shape:
            # wide intervals must not make this an empty promise
            assert abs(interval.estimate - truth[name]) < 0.5 * abs(truth[name] - f.parameter.neutral) or truth[name] == pytest.approx(
                f.parameter.neutral
            ), name
    assert np.allclose(done.fit.theta, [0.46, 0.60], atol=0.005)


@pytest.mark.slow
@pytest.mark.parametrize("effect_id", JUMPS)
def test_jumping_friction_shrinks_the_gap_to_the_rig(effect_id):
    done, _ = estimates(effect_id, "rig", 3)
    base = float(np.sqrt(np.average(done.base.residual**2, weights=done.sim.weight)))
    assert done.rms_n < 0.99 * base


@pytest.fixture(scope="module")
def problem():
    return prepare(TABLE.record("zero_offset", "transmission", 0.01, 1))


@pytest.mark.parametrize("effect_id", FITTED)
def test_batched_equals_single(effect_id, problem):
    theta = np.array([0.46, 0.60])
    effects = {effect_id: strengths(effect_id)}
    batch = Simulator(problem, Mechanics())
    together = batch.predict(theta, effects)
    for record, part in zip(problem.records, batch.slices(), strict=True):
        alone = Simulator(Problem((record,), problem.configs, {}, problem.analysis_hz), Mechanics())
        assert np.array_equal(alone.predict(theta, effects), together[part])
    assert not np.array_equal(together, batch.predict(theta, {}))

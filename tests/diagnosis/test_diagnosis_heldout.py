"""Held-out errors: what is left out is predicted from the rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, NOTHING, made, named, noise, simulator
from made_sims import sim

from sstl_cli.diagnosis.constants import ALL_COUNT, MAX_FOLDS, THETA_HIGH, THETA_LOW
from sstl_cli.diagnosis.fit import Fit, normal_equations
from sstl_cli.diagnosis.heldout import Folds, _step, blocks, held_out_residual, make_folds, predicted_nats
from sstl_cli.diagnosis.hypotheses import Hypothesis, full
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import white

U = np.arange(20.0)
OUT = Hypothesis(("zero_offset",), tuple(f for f in full("zero_offset", ("act",)).free if f.parameter.name == "z_out_act_n"))


@pytest.mark.parametrize(
    "records, kind, honest, folds",
    [
        ([{"trajectory": "ramp"}, {"trajectory": "chirp"}, {"trajectory": "ramp"}], "trajectory", True, [1, 0, 1]),
        ([{"config": 1}, {"config": 0}, {"config": 1}], "configuration", True, [1, 0, 1]),
        ([{}, {}, {}], "run", False, [0, 1, 2]),
    ],
)
def test_what_differs_most_is_held_out(records, kind, honest, folds):
    found = make_folds(sim(*[(U, r) for r in records], configs=tuple("ab")[: 1 + (kind == "configuration")]))
    assert (found.kind, found.honest, found.count) == (kind, honest, max(folds) + 1)
    assert np.array_equal(found.of_sample, np.repeat(folds, 20))


def test_the_only_run_is_cut_in_four_and_that_is_said():
    found = make_folds(sim((U, {})))
    assert np.array_equal(found.of_sample, np.repeat([0, 1, 2, 3], 5)) and not found.honest and found.count == 4


def test_many_trajectories_share_folds():
    found = make_folds(sim(*[(U, {"trajectory": f"t{i:02}"}) for i in range(MAX_FOLDS + 2)]))
    assert found.count == MAX_FOLDS and found.of_sample[-1] == 1


def test_blocks_last_five_seconds_and_end_with_their_run():
    # 0.1 s a sample: 50 samples a block; the second run begins its own
    assert np.bincount(blocks(sim((np.zeros(120), {}), (np.zeros(60), {})))).tolist() == [50, 50, 20, 50, 10]


def off(by_run) -> Fit:
    """Return a fit whose theta is off by a number a run: its residual is so many times the slope in theta."""
    f = made()
    return replace(f, residual=f.jacobian[:, 0] * np.asarray(by_run)[simulator().run])


def test_a_configuration_held_out_as_a_whole_is_given_its_own_theta():
    f = off([0.01, -0.02, 0.01, -0.02])
    left = held_out_residual(simulator(), f, make_folds(simulator()))
    assert np.abs(left).max() < 1e-9 < np.abs(f.residual).max()


def test_a_trajectory_held_out_is_predicted_by_the_theta_of_the_others():
    known = simulator().problem
    labelled = Simulator(
        replace(known, records=tuple(replace(r, trajectory="xxyy"[i]) for i, r in enumerate(known.records))), simulator().mechanics
    )
    f = off([0.02, 0.0, 0.05, 0.0])
    left = held_out_residual(labelled, f, make_folds(labelled))
    # runs 0 and 2 are of one configuration: each is predicted as the other asks for
    expected = f.jacobian[:, 0] * np.array([-0.03, 0.0, 0.03, 0.0])[labelled.run]
    # all that there is beforehand draws by a thousandth
    assert left == pytest.approx(expected, rel=5e-3, abs=1e-7) and f.hypothesis is NOTHING


def test_what_is_held_out_takes_no_part_in_its_own_prediction():
    known = simulator().problem
    labelled = Simulator(
        replace(known, records=tuple(replace(r, trajectory="xyz"[i % 3], config=0) for i, r in enumerate(known.records)), configs=("a",)),
        simulator().mechanics,
    )
    f = off([0.0, 0.0, 0.3, 0.0])
    f = replace(f, theta=f.theta[:1])
    left = held_out_residual(labelled, f, make_folds(labelled))
    third = labelled.run == 2
    # the others ask for no change: all of it is left; they are drawn away by what the third asks for
    assert left[third] == pytest.approx(f.residual[third], abs=1e-6)
    assert np.abs(left[labelled.run == 1]).max() > 0.01


def test_parameters_follow_the_training_part_too():
    f = made(0.0, OUT, (0.1,))
    by_run = np.array([0.3, 0.3, 0.5, 0.5])[simulator().run]
    f = replace(f, residual=f.jacobian[:, 1] * by_run)
    by_half = Folds((simulator().run // 2).astype(np.int64), 2, "run", False)
    left = held_out_residual(simulator(), f, by_half)
    # each half is predicted with the offset of the other: 0.2 N too little or too much
    assert left == pytest.approx(f.jacobian[:, 1] * np.array([-0.2, -0.2, 0.2, 0.2])[simulator().run], rel=6e-3)
    configuration = held_out_residual(simulator(), f, make_folds(simulator()))
    # with theta of its own a configuration still takes the offset of the other, which is the mean of the same two
    assert np.abs(configuration).max() < np.abs(f.residual).max()


def test_what_a_training_part_cannot_tell_it_does_not_foretell_wrongly():
    """A pulley where each movement was recorded of one system in a bend: without the other movement theta says the same."""
    f = made(noise(8), OUT, (0.1,))
    run, theta = simulator().run, f.jacobian[:, 0]
    # runs 0 (of a) and 3 (of b) have it, like theta there to a ten-thousandth
    like = np.where((run == 0) | (run == 3), theta * (1.0 + 1e-4 * np.sin(np.arange(len(run)))), 0.0)
    # what is left has a trace that only so little a difference explains
    f = replace(f, jacobian=np.column_stack((theta, like)), residual=np.where(run == 0, like - theta, 0.0))
    whitened, out = (f.whiten(f.jacobian), f.whiten(f.residual)), run // 2 == 1
    everything = normal_equations(simulator(), *whitened)[0]
    told, untold = (_step(simulator(), f, whitened, share * everything, out)[-1] for share in (ALL_COUNT, 0.0))
    assert abs(told) < 0.02 < 0.2 < abs(untold)


def test_a_step_that_the_training_part_does_not_bear_is_damped():
    f = made(0.0, OUT, (0.1,))
    run = simulator().run
    # runs 0 and 1 hardly say anything of the offset: by their slope it would have to be 50 N
    slope = np.where(run < 2, 1e-3, 1.0)
    f = replace(f, jacobian=f.jacobian * np.column_stack((np.ones(len(run)), slope)), residual=np.where(run < 2, 0.05, 0.0))
    left = held_out_residual(simulator(), f, Folds((run // 2).astype(np.int64), 2, "trajectory", True))
    free = f.free[0].parameter
    assert min(free.most - 0.1, 50.0) > 1.0
    assert np.abs(left[run >= 2]).max() < 0.1


def thinned(residual, h, values) -> Fit:
    """Return a fit that sees one sample in eighty: a hundred in all."""
    model = simulator()
    return replace(made(residual, h, values), whiten=white(NOISE_N, np.arange(len(model.y)) % 80 == 7, [s.start for s in model.slices()]))


@pytest.mark.parametrize(("effect", "parameter", "value"), [("zero_offset", "z_out_act_n", 0.1), ("gain_error", "g_act", 1.1)])
def test_what_is_foretold_is_the_density_of_a_fold_given_the_others(effect, parameter, value):
    """By dense covariances: theta of two bends and a parameter, of which the others leave what they leave."""
    chosen = named(effect, parameter)
    f = thinned(noise(3), chosen, (value,))
    model, folds = simulator(), make_folds(simulator())
    kept = np.flatnonzero(f.whiten.scale > 0)
    j = np.zeros((len(kept), 3))
    j[np.arange(len(kept)), model.config[kept]] = f.jacobian[kept, 0]
    j[:, 2] = f.jacobian[kept, 1]
    before = np.diag([(THETA_HIGH - THETA_LOW) ** 2] * 2 + [chosen.free[0].width ** 2])
    # the fit stands 0.1 off what is expected beforehand: that it is not there
    mean = j @ np.array([0.0, 0.0, -0.1])

    def nats(at):
        cov = NOISE_N**2 * np.eye(len(at)) + j[at] @ before @ j[at].T
        left = f.residual[kept][at] - mean[at]
        return 0.5 * float(left @ np.linalg.solve(cov, left)) + 0.5 * np.linalg.slogdet(cov)[1]

    of = folds.of_sample[kept]
    dense = sum(nats(np.arange(len(kept))) - nats(np.flatnonzero(of != k)) for k in range(folds.count))
    assert predicted_nats(model, f, folds) == pytest.approx(dense, rel=1e-8)


def test_a_cause_is_foretold_from_one_bend_to_the_other_and_what_differs_is_not():
    offset, model = named("zero_offset", "z_out_act_n"), simulator()
    folds, base = make_folds(model), NOTHING
    for by_bend, foretold in (((0.1, 0.1), True), ((0.1, -0.1), False)):
        moved = noise(4) + np.array(by_bend)[model.config]
        found = float(np.mean(by_bend))
        kept = predicted_nats(model, made(moved, base), folds) - predicted_nats(model, made(moved - found, offset, (found,)), folds)
        assert (kept > 50.0) == foretold and (foretold or kept < 5.0)


def test_what_two_parameters_say_alike_is_said_once():
    both = full("zero_offset", ("act",))
    f = made(noise(5), both, (0.0, 0.0))
    alike = replace(f, jacobian=1e9 * f.jacobian[:, [0, 1, 1]])
    one = replace(alike, hypothesis=named("zero_offset", "z_in_act_n"), values=np.zeros(1), jacobian=1e9 * f.jacobian[:, [0, 1]])
    folds = make_folds(simulator())
    assert predicted_nats(simulator(), alike, folds) == pytest.approx(predicted_nats(simulator(), one, folds), abs=0.01)

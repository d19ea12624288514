"""What a fit is worth beside the base: its gain less its charges, and nothing where it explains by not propagating."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import THETA, made, noise, simulator

from sstl_cli.diagnosis.constants import LOG_RANGE, THETA_HIGH, THETA_LOW
from sstl_cli.diagnosis.evidence import Weighed, information, likeness_charge, shape_charge, standard_errors, strengths_charge, weigh
from sstl_cli.diagnosis.free import Free
from sstl_cli.diagnosis.hypotheses import full, variants
from sstl_cli.physics.effect import NOMINAL_THETA, Parameter
from sstl_cli.physics.effects import get

SIM = simulator()
GAIN, FRICTION = full("gain_error", ("act",)), variants("const_friction", ("act",))[0]
ONE = made(noise(), GAIN, (1.05,))


def over(f, nats):
    """Return a base that a fit gains so many nats over."""
    return replace(made(noise()), cost=f.cost + nats)


def at(f, theta):
    return replace(f, theta=np.array(theta))


def test_one_effect_is_charged_by_its_whole_gain():
    w = weigh(SIM, ONE, over(ONE, 40.0))
    assert w.ids == ("gain_error",) and w.gain == pytest.approx(40.0)
    assert w.evidence == pytest.approx(40.0 - strengths_charge(1, 80.0))
    # two strengths of one effect are charged together
    zero = made(noise(), full("zero_offset", ("act",)), (0.1, 0.2))
    assert weigh(SIM, zero, over(zero, 40.0)).evidence == pytest.approx(40.0 - strengths_charge(2, 80.0))


def test_of_several_each_is_charged_by_what_it_adds_to_the_others():
    both = made(noise(), GAIN.joined(FRICTION), (1.05, 0.1))
    parts = [Weighed(ONE, 30.0, 0.0), Weighed(made(noise(), FRICTION, (0.1,)), 25.0, 0.0)]
    w = weigh(SIM, both, over(both, 40.0), parts)
    # friction adds 10 to the gain error, that one 15 to friction, and they look alike in part
    alike = likeness_charge(information(SIM, both), [[len(THETA)], [len(THETA) + 1]])
    assert 0.5 < alike < 1.0
    assert w.evidence == pytest.approx(40.0 - strengths_charge(1, 20.0) - strengths_charge(1, 30.0) - alike)
    assert weigh(SIM, both, over(both, 40.0), parts[:1]).evidence == pytest.approx(
        40.0 - strengths_charge(1, 20.0) - strengths_charge(1, 80.0) - alike
    )
    # what lacks more than one of them says nothing of either
    assert weigh(SIM, both, over(both, 40.0), [Weighed(made(noise()), 30.0, 0.0)]).evidence == pytest.approx(
        40.0 - 2.0 * strengths_charge(1, 80.0) - alike
    )


def test_a_shape_costs_by_how_well_the_data_hold_it():
    slow = next(h for h in variants("stribeck", ("act",)) if [f.parameter.name for f in h.free] == ["mean_ratio", "mean_mm_s"])
    f = made(noise(), slow, (1.3, 2.0))
    se = standard_errors(f, information(SIM, f))
    w = weigh(SIM, f, over(f, 900.0))
    assert (
        w.evidence == pytest.approx(900.0 - strengths_charge(1, 1800.0) - shape_charge(slow.free[1], 2.0, float(se[1])))
        and shape_charge(slow.free[1], 2.0, float(se[1])) > 0.5
    )


def test_a_shape_from_nothing_is_even_over_its_range_and_what_is_held_exactly_costs_no_more_than_a_million():
    linear = Free(get("presliding"), Parameter("spread", "1", 0.5, 0.0, 4.0, "", shape=True))
    assert shape_charge(linear, 0.3, 0.1) == pytest.approx(np.log(4.0 / (np.sqrt(2.0 * np.pi) * 0.1)))
    assert shape_charge(linear, 0.3, 0.0) == 0.0 and shape_charge(linear, 0.3, 1e-12) == pytest.approx(np.log(1e6))


def test_what_a_small_response_costs_is_what_one_of_unit_size_does():
    assert strengths_charge(1, 0.01) == strengths_charge(1, 1.0) < strengths_charge(1, 1.1)


@pytest.mark.parametrize(
    ("theta", "stopped"),
    [([0.5, 0.6], False), ([THETA_LOW, 0.6], True), ([0.5, THETA_HIGH], True), ([1.01 * THETA_LOW, 0.99 * THETA_HIGH], False)],
)
def test_a_line_that_has_stopped_or_lost_its_friction_explains_nothing(theta, stopped):
    w = weigh(SIM, at(ONE, theta), over(ONE, 40.0))
    assert w.gain == pytest.approx(40.0) and w.evidence == (0.0 if stopped else pytest.approx(40.0 - strengths_charge(1, 80.0)))
    # nor does it cost less than it did
    loss = weigh(SIM, at(ONE, theta), over(ONE, -40.0))
    assert loss.evidence == pytest.approx(-40.0 - strengths_charge(1, -80.0))


def test_a_bend_that_had_no_friction_when_the_rig_was_modelled_may_have_none():
    straight = replace(SIM, accepted=np.array([THETA_LOW, 0.6]))
    assert weigh(straight, at(ONE, [THETA_LOW, 0.6]), over(ONE, 40.0)).evidence > 0.0
    assert weigh(straight, at(ONE, [THETA_LOW, THETA_LOW]), over(ONE, 40.0)).evidence == 0.0
    stuck = replace(SIM, accepted=np.array([THETA_HIGH, 0.6]))
    assert weigh(stuck, at(ONE, [THETA_HIGH, 0.6]), over(ONE, 40.0)).evidence > 0.0
    assert weigh(replace(SIM, accepted=THETA), at(ONE, [THETA_HIGH, 0.6]), over(ONE, 40.0)).evidence == 0.0


def test_a_friction_that_is_as_good_as_none_counts_for_what_its_absence_explains():
    """A bend with next to no friction when the rig was modelled, fitted with none: what it would cost to have it is taken off."""
    charge, off = strengths_charge(1, 80.0), 1e-4
    some = replace(SIM, accepted=np.array([THETA_LOW + off, 0.6]))
    w = weigh(some, at(ONE, [THETA_LOW, 0.6]), over(ONE, 40.0))
    known = information(some, ONE)
    alone = known[0, 0] - known[0, 1:] @ np.linalg.solve(known[1:, 1:], known[1:, 0])
    assert w.evidence == pytest.approx(40.0 - charge - 0.5 * alone * off**2) and 0.0 < 40.0 - charge - w.evidence < 10.0


def test_beside_a_wrong_gain_the_friction_of_the_base_is_no_measure():
    """Without friction a gain is charged for the least of which fits begin; another effect, and a gain beside an accepted model, for the base's."""
    known = at(ONE, [THETA_LOW, 0.6])
    a = information(SIM, known)
    alone = a[0, 0] - a[0, 1:] @ np.linalg.solve(a[1:, 1:], a[1:, 0])
    least = 0.5 * alone * (0.03 * NOMINAL_THETA - THETA_LOW) ** 2
    gain = 2.0 * least + 100.0
    w = weigh(SIM, known, over(known, gain))
    assert w.evidence == pytest.approx(gain - strengths_charge(1, 2.0 * gain) - least)
    rubbing = at(made(noise(), FRICTION, (0.1,)), [THETA_LOW, 0.6])
    assert weigh(SIM, rubbing, over(rubbing, gain)).evidence == 0.0
    # a line that has stopped does not propagate, whatever the gain
    assert weigh(SIM, at(ONE, [0.5, THETA_HIGH]), over(ONE, 40.0)).evidence == 0.0
    assert weigh(replace(SIM, accepted=THETA), known, over(known, 40.0)).evidence == 0.0


def test_where_the_base_is_as_still_nobody_explains_by_standing_still():
    """Bends that hold nearly everything back: theta is at its largest with a candidate and without."""
    still = replace(over(ONE, 40.0), theta=np.array([THETA_HIGH, 0.6]))
    assert weigh(SIM, at(ONE, [THETA_HIGH, 0.6]), still).evidence == pytest.approx(40.0 - strengths_charge(1, 80.0))
    assert weigh(replace(SIM, accepted=THETA), at(ONE, [THETA_HIGH, 0.6]), still).evidence > 0.0
    # but not of another bend
    assert weigh(SIM, at(ONE, [THETA_HIGH, THETA_HIGH]), still).evidence == 0.0


@pytest.mark.parametrize(("likeness", "size"), [(0.0, 8.0), (0.9, 8.0), (0.99, 8.0), (0.999, 12.0)])
def test_a_pair_is_charged_as_the_integral_over_both_strengths(likeness, size):
    """Two strengths of a linear model with unit information each, as large as that many standard deviations beside one another."""
    known = np.array([[1.0, likeness], [likeness, 1.0]])
    best = np.full(2, size / np.sqrt(1.0 - likeness**2))
    # density of either: alike in every decade, both signs; steps along the axes of the ellipsoid
    width, axes = np.linalg.eigh(known)
    step = np.linspace(-7.0, 7.0, 401)
    grid = np.stack(np.meshgrid(step, step)).reshape(2, -1)
    place = best[:, None] + axes @ (grid / np.sqrt(width)[:, None])
    density = 1.0 / np.prod(2.0 * LOG_RANGE * np.maximum(np.abs(place), 1e-3), axis=0)
    volume = float(np.sum(np.exp(-0.5 * (grid**2).sum(axis=0)) * density)) * (step[1] - step[0]) ** 2 / np.sqrt(width.prod())
    charge = 2.0 * strengths_charge(1, size**2) + likeness_charge(known, [[0], [1]])
    assert charge == pytest.approx(-np.log(volume), abs=0.1)


def test_what_is_integrated_out_and_what_is_one_effect_make_no_likeness():
    known = np.array([[1.0, 0.6, 0.0], [0.6, 1.0, 0.8], [0.0, 0.8, 1.0]])
    # of three strengths the last two are one effect: det of all over det of that effect
    both = likeness_charge(known + 0.5 * np.eye(3), [[0], [1, 2]])
    whole, own = np.linalg.det(known + 0.5 * np.eye(3)), 1.5 * np.linalg.det((known + 0.5 * np.eye(3))[1:, 1:])
    assert both == pytest.approx(0.5 * np.log(own / whole))
    # a nuisance that the second strength goes along with leaves it less information of its own
    nuisance = known + np.diag([0.0, 0.2, 0.0])
    left = np.array([[1.0, 0.6], [0.6, 1.2 - 0.64]])
    assert likeness_charge(nuisance, [[0], [1]]) == pytest.approx(-0.5 * np.log(np.linalg.det(left) / (left[0, 0] * left[1, 1])))
    assert likeness_charge(known, [[0, 1], []]) == 0.0


def test_what_cannot_be_told_apart_at_all_and_what_is_not_known_make_no_likeness():
    # two copies of one column have no volume, and a column without information has none of its own
    assert likeness_charge(np.ones((2, 2)), [[0], [1]]) == likeness_charge(np.diag([1.0, 0.0]), [[0], [1]]) == 0.0
    # what is independent costs nothing, whatever it is counted in, and a single effect never does
    assert likeness_charge(np.diag([4.0, 1e-6, 9.0]), [[0], [1], [2]]) == pytest.approx(0.0, abs=1e-12)
    assert likeness_charge(np.array([[2.0, 1.9], [1.9, 2.0]]), [[0, 1]]) == 0.0
    scaled = np.diag([1.0, 1e3]) @ np.array([[1.0, 0.8], [0.8, 1.0]]) @ np.diag([1.0, 1e3])
    assert likeness_charge(scaled, [[0], [1]]) == pytest.approx(-0.5 * np.log(1.0 - 0.8**2))


def test_the_information_is_that_of_whitened_columns_and_of_nothing_next_to_none():
    f = made(noise(), GAIN, (1.05,))
    white, own = f.whiten(f.jacobian), np.zeros((len(SIM.y), 3))
    own[np.arange(len(SIM.y)), SIM.config], own[:, 2] = white[:, 0], white[:, 1]
    assert information(SIM, f) == pytest.approx(own.T @ own, rel=1e-9)
    # the larger the information the less a parameter is off: two standard errors by a dense inverse
    dense = np.sqrt(np.diag(np.linalg.inv(own.T @ own)))
    assert standard_errors(f, information(SIM, f)) == pytest.approx(dense[2:], rel=1e-6) and dense[2] < 0.1
    silent = replace(f, jacobian=np.column_stack((f.jacobian[:, 0], np.zeros(len(SIM.y)))))
    known = information(SIM, silent)
    assert 0.0 < known[2, 2] < 1e-9 and np.isfinite(standard_errors(silent, known)).all()


def test_three_effects_that_look_alike_are_charged_together():
    known = np.array([[2.0, 0.9, 0.4], [0.9, 1.0, 0.3], [0.4, 0.3, 1.5]])
    expected = 0.5 * (np.log(2.0 * 1.0 * 1.5) - np.linalg.slogdet(known)[1])
    assert likeness_charge(known, [[0], [1], [2]]) == pytest.approx(expected) and expected > 0.2

"""What a named effect is worth to a controller: knowing it must not hurt."""

import numpy as np
import pytest

from sstl_cli.control.controller import Theta
from sstl_cli.control.plant import Plant, PlayTendon
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis import downstream
from sstl_cli.physics.scenario import Configuration, Scenario

THETA = 0.55


def model(theta=THETA, **effects):
    return Scenario(configurations=(Configuration(id="a", location="CP", theta=theta),), effects=effects)


def test_lines_of_an_exact_plant_are_its_own():
    """The sample at the peak moves neither way: in the release fit it tilted the line by a tenth."""
    own = Theta(0.58, -1.4, 1.69, -1.0)
    found = downstream.lines_of(Plant(PlayTendon(own)))
    assert (found.gamma_p, found.beta_p) == pytest.approx((0.58, -1.4), abs=1e-9)
    assert (found.gamma_r, found.beta_r) == pytest.approx((1.69, -1.0), abs=1e-9)


def test_an_exact_plant_is_tracked_exactly():
    for t in downstream.tracking(model(), "a", model()):
        assert t.rmse_without_n < 1e-6 and t.rmse_with_n < 1e-6
    for t in downstream.tracking(model(), "a", model(THETA + 0.1)):
        assert t.rmse_without_n > 0.3 and t.rmse_with_n < 1e-6


@pytest.mark.parametrize(
    ("effect", "values", "at_most"),
    [
        ("asymmetric_friction", {"a": 0.1}, 0.01),
        ("const_friction", {"w_l_n": 0.3}, 0.01),
        ("presliding", {"breakaway_mm": 0.3, "spread": 0.5}, 0.6),
        ("load_dependent_friction", {"alpha": 0.2}, 0.1),
        ("sheath_compliance", {"c_t_per_n": 0.005}, 0.1),
        ("stribeck", {"ratio": 1.3, "v_s_mm_s": 1.0}, 0.8),
    ],
)
def test_a_controller_that_knows_the_effect_is_better(effect, values, at_most):
    for t in downstream.tracking(model(**{effect: values}), "a", model()):
        assert t.rmse_with_n < at_most * t.rmse_without_n, t.reference


def test_a_controller_without_what_is_new_knows_what_the_simulator_held():
    """A simulator that was given with its constant friction: the controller of before knew it."""
    monday, friday = {"const_friction": {"w_l_n": 0.4}}, {"asymmetric_friction": {"a": 0.02}}
    for t in downstream.tracking(model(**monday), "a", model(**monday)):
        assert t.rmse_without_n < 0.01, t.reference
    changed = downstream.tracking(model(**monday, **friday), "a", model(**monday))
    for t, bare in zip(changed, downstream.tracking(model(**monday, **friday), "a", model()), strict=True):
        assert t.rmse_with_n < 0.2 * t.rmse_without_n and t.rmse_without_n < bare.rmse_without_n, t.reference


@pytest.mark.parametrize("theta", [THETA, THETA + 0.03, THETA + 0.1])
def test_friction_that_drifts_on_its_way_is_met_where_the_task_is(theta):
    """Lines of a first full stroke are those of friction that the task has long left behind: 0.028 N became 0.047 N."""
    for t in downstream.tracking(model(friction_drift={"d_mu": 0.2, "path_n": 200.0}), "a", model(theta)):
        assert t.rmse_with_n <= t.rmse_without_n and t.rmse_with_n < 0.2, t.reference


def test_a_tendon_that_never_slides_is_an_error():
    with pytest.raises(SstlError, match="E920"):
        downstream.lines_of(Plant(lambda t_in, dt: np.full(len(t_in), 3.0)))

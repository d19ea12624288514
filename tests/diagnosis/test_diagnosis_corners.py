"""What does the input do at corners? Holds of known size say so, whatever else is off."""

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.corners import likelier, passes
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.filters import first_order
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import drive_of

RNG = np.random.default_rng(8)
CORNERS = np.where(np.arange(20) % 2 == 0, 1.0, -1.0) * RNG.uniform(0.0, 0.04, 20)

NO_SLOPES = np.zeros((0, 20))


@pytest.mark.parametrize(
    ("left", "said"),
    [
        (CORNERS + 0.01 * RNG.standard_normal(20), True),
        (2.0 * CORNERS + 0.01 * RNG.standard_normal(20), True),
        (0.01 * RNG.standard_normal(20), False),
        # an effect that opens or closes the loop, and one that shifts it
        (4.0 * CORNERS, False),
        (-CORNERS, False),
        (0.2 + CORNERS, False),
        # too noisy to tell
        (CORNERS + 0.1 * RNG.standard_normal(20), False),
    ],
)
def test_holds_off_by_what_corners_add_say_that_the_input_passes_them(left, said):
    found = passes(left, CORNERS[None], NO_SLOPES)
    assert (found is not None) is said
    if found is not None:
        # what is open of corners is what holds leave, at most that of anywhere between sample and corner
        rest = np.sum((left - CORNERS) ** 2) / np.sum(CORNERS**2)
        assert found == (0, pytest.approx(min(rest, 1.0 / 3.0)))


def test_of_several_ways_the_nearest_is_taken_and_theta_is_nobodys_evidence():
    left = 0.5 * CORNERS + 0.001 * RNG.standard_normal(20)
    ways = np.stack([CORNERS, 0.8 * CORNERS, 0.5 * CORNERS])
    best = passes(left, ways, NO_SLOPES)
    assert best is not None and best[0] == 2 and best[1] < 0.01
    # holds that theta moves in the same measure say nothing; others that it moves change nothing
    assert passes(left, ways, np.stack([CORNERS])) is None
    assert passes(left + 0.3 * np.ones(20), ways, np.stack([np.ones(20)])) == (2, pytest.approx(best[1], rel=0.5))


def test_no_hold_or_no_corner_says_nothing():
    assert passes(np.zeros(0), np.zeros((1, 0)), np.zeros((0, 0))) is None
    assert passes(np.ones(3), np.zeros((1, 3)), np.zeros((0, 3))) is None


@pytest.mark.parametrize(
    ("finer", "lag_s", "noise_n", "said"),
    [
        (1, 0.0, 0.005, (False, None)),
        (1, 0.0, 0.02, (False, None)),
        (100, 0.0, 0.005, (False, 0.0)),
        (100, 0.0, 0.02, (False, 0.0)),
        (100, 0.003, 0.005, (False, 0.0025)),
        (100, 0.01, 0.02, (True, None)),
    ],
)
def test_holds_tell_a_stepped_rig_from_a_steady_one_and_from_a_drive_that_lags(finer, lag_s, noise_n, said):
    # corners at instants of their own, marched a hundred times finer than they are read, or just as they are read
    time = np.arange(4000 * finer) * 0.01 / finer
    pull = 15.0 + 12.0 * np.interp((time * 1.037 + 0.3) % 4.0, [0.0, 2.0, 4.0], [-1.0, 1.0, -1.0])
    pull = first_order(pull, 0.01 / finer, lag_s)
    out = predict(drive_of("act", "CP", 0.01 / finer, pull, Mechanics()), 0.5, activate({}))
    noise = noise_n * np.random.default_rng(3).standard_normal((2, 4000))
    run = Run("a", "act", time[::finer], pull[::finer] + noise[0], out[::finer] + noise[1], config_id="b", location="CP")
    sim, theta = likelier(Simulator(prepare([run], 1.0), Mechanics()), np.array([0.5]))
    (r,) = sim.problem.records
    assert (r.rounded, None if r.passes is None else round(r.passes.lag_s, 6)) == said and theta == pytest.approx([0.5], rel=0.01)

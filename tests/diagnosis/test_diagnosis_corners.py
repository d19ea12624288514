"""Does the input pass its samples at corners? Holds of known size say so, whatever else is off."""

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.corners import likelier, passes
from sstl_cli.diagnosis.records import passing, prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import drive_of

RNG = np.random.default_rng(8)
CORNERS = np.where(np.arange(20) % 2 == 0, 1.0, -1.0) * RNG.uniform(0.0, 0.04, 20)


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
    assert passes(left, CORNERS) is said


def test_no_hold_or_no_corner_says_nothing():
    assert not passes(np.zeros(0), np.zeros(0)) and not passes(np.ones(3), np.zeros(3))


@pytest.mark.parametrize("passed", [False, True])
def test_a_steady_rig_passes_its_samples_and_a_stepped_one_does_not(passed):
    # corners at instants of their own, marched a hundred times finer than they are read, or just as they are read
    finer = 100 if passed else 1
    time = np.arange(4000 * finer) * 0.01 / finer
    pull = 15.0 + 12.0 * np.interp((time * 1.037 + 0.3) % 4.0, [0.0, 2.0, 4.0], [-1.0, 1.0, -1.0])
    out = predict(drive_of("act", "CP", 0.01 / finer, pull, Mechanics()), 0.5, activate({}))
    noise = np.random.default_rng(3).standard_normal((2, 4000))
    run = Run("a", "act", time[::finer], pull[::finer] + 0.005 * noise[0], out[::finer] + 0.005 * noise[1], config_id="b", location="CP")
    both = passing(prepare([run], 1.0))
    assert len(both) == 2
    sims = [Simulator(p, Mechanics()) for p in both]
    sim, theta = likelier(sims, np.array([0.5]))
    assert sim is sims[int(passed)] and theta == pytest.approx([0.5], rel=0.01)

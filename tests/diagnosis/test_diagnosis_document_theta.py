"""What theta has become beside the effects that are named."""

from __future__ import annotations

import numpy as np
import pytest
from made_fits import THETA, gained, made, noise, simulator, thetas

from sstl_cli.diagnosis.bends import _lost
from sstl_cli.diagnosis.hypotheses import variants

GAIN = variants("gain_error", ("act",))[0]


def test_another_theta_costs_what_the_parameters_cannot_make_up_for():
    f = made(noise(5), GAIN, (1.02,))
    moved = THETA + np.array([0.01, -0.004])
    shift = thetas(f) @ (moved - f.theta)
    # what is left of the shift where the gain follows
    kept = 0.5 * float(shift @ shift) - gained(f.whiten(f.jacobian[:, 1:]), np.zeros((len(shift), 0)), shift)
    assert _lost(simulator(), f, moved) == pytest.approx(kept, rel=1e-4) and kept > 10.0
    assert _lost(simulator(), f, f.theta) == 0.0

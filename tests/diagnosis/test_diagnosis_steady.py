"""A rig that moves steadily, read a hundred times a second: without an effect nothing is missing, with one it is that."""

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.gathering import gather
from sstl_cli.diagnosis.question import Question
from sstl_cli.diagnosis.verdict import verdict
from sstl_cli.diagnosis.weights import learned
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.filters import first_order
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import drive_of

FEW = ("const_friction", "zero_offset", "viscous", "channel_delay", "channel_lowpass", "presliding", "pulley_friction")
RATE_HZ, FINER, SECONDS = 100, 20, 20


def recorded(lag_s, noise_n, seed, effects):
    """Return runs of two bends and both systems: ramps between corners at any instants, behind a drive that lags."""
    rng = np.random.default_rng(seed)
    time = np.arange(SECONDS * RATE_HZ * FINER) / RATE_HZ / FINER
    dt, found = 1.0 / RATE_HZ / FINER, []
    for config, theta, place in (("a", 0.5, "NP"), ("b", 0.65, "CP")):
        for system in ("act", "sstl", "act", "sstl"):
            corners = np.concatenate(([0.0], np.cumsum(rng.uniform(1.0, 4.0, 40))))
            levels = np.where(np.arange(41) % 2 == 0, rng.uniform(1.5, 9.0, 41), rng.uniform(14.0, 28.0, 41))
            pull = first_order(np.interp(time, corners, levels), dt, lag_s)
            out = predict(drive_of(system, place, dt, pull, Mechanics()), theta, activate(effects))
            read = [x[::FINER] + noise_n * rng.standard_normal(SECONDS * RATE_HZ) for x in (pull, out)]
            found.append(Run(f"r{len(found)}", system, time[::FINER], *read, config_id=config, location=place))
    return found


def said(lag_s, noise_n, seed, effects):
    found = gather(recorded(lag_s, noise_n, seed, effects), Question(effects=FEW, max_effects=1))
    return verdict(found.rows, learned())


@pytest.mark.parametrize(
    ("lag_s", "noise_n", "seed"),
    [
        pytest.param(0.0, 0.005, 2, marks=pytest.mark.slow),
        pytest.param(0.0, 0.02, 1, marks=pytest.mark.slow),
        pytest.param(0.01, 0.02, 1, marks=pytest.mark.slow),
        pytest.param(0.01, 0.005, 2, marks=pytest.mark.slow),
    ],
)
def test_nothing_is_missing_of_a_steady_rig(lag_s, noise_n, seed):
    """It passes its samples at corners, or rounds them: each hold was off by that, and a delay gained 143 nats."""
    assert said(lag_s, noise_n, seed, {}).status == "none"


@pytest.mark.slow
def test_what_is_missing_of_a_steady_rig_is_named():
    assert said(0.0, 0.01, 3, {"const_friction": {"w_l_n": 0.15}}).effects == ("const_friction",)

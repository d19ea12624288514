"""The lag of a tension loop from command and measured tension: against the closed form and a loop that is no first-order one."""

import numpy as np
import pytest

from sstl_cli.control import loop_lag
from sstl_cli.core.errors import SstlError
from sstl_cli.physics.rig import NoiseSpec, RigRun, RigSpec, simulate_rig

DT = 0.002
TIME = np.arange(3000) * DT
COMMAND = np.where(TIME < 1.0, 5.0, 20.0)


def lagging(tau_s, delay_s=0.0):
    """The answer of a first-order loop to the step at 1 s, in closed form: it begins to move with the first sample after it."""
    since = TIME - 1.0 - delay_s + DT
    return np.where(since > 0.0, 20.0 - 15.0 * np.exp(-np.maximum(since, 0.0) / tau_s), 5.0)


@pytest.mark.parametrize("tau_s", [0.02, 0.3, 1.0])
def test_a_step_response_gives_its_time_constant(tau_s):
    noise = 0.02 * np.random.default_rng(1).standard_normal(len(TIME))
    found = loop_lag.identify(COMMAND, lagging(tau_s) + noise, DT)
    assert found.tau_s == pytest.approx(tau_s, abs=5 * found.error_s)
    assert 0.0 < found.error_s < 1e-3 * max(tau_s, 0.1) * 5 and found.delay_s == 0.0
    assert found.rms_n == pytest.approx(0.02, rel=0.05)


def test_the_standard_error_is_that_of_repeated_recordings():
    rng = np.random.default_rng(2)
    found = [loop_lag.identify(COMMAND, lagging(0.3) + 0.02 * rng.standard_normal(len(TIME)), DT) for _ in range(40)]
    assert np.std([f.tau_s for f in found]) == pytest.approx(found[0].error_s, rel=0.4)


def test_a_dead_time_is_told_apart_from_the_lag():
    noise = 0.02 * np.random.default_rng(3).standard_normal(len(TIME))
    found = loop_lag.identify(COMMAND, lagging(0.3, 0.05) + noise, DT)
    assert found.delay_s == pytest.approx(0.05, abs=DT / 2) and found.tau_s == pytest.approx(0.3, abs=0.002)


def test_a_loop_of_another_kind_leaves_more_than_noise():
    """The rig's PID and motor: the lag is near its integral gain's, and what is left says that it is no first-order loop."""
    command = np.interp(TIME, [0.0, 3.0, 6.0], [2.0, 30.0, 2.0])
    r = simulate_rig(RigSpec(pretension_n=1.0), RigRun("act", 0.5, "CP", TIME, "loop", command), {}, NoiseSpec(), 0)
    found = loop_lag.identify(command, r.tension_in_n, DT)
    assert 0.02 < found.tau_s < 0.2 and found.rms_n > 0.05


@pytest.mark.parametrize(
    ("command", "measured"),
    [(COMMAND[:20], COMMAND[:20]), (np.full(100, 5.0), np.full(100, 5.0)), (COMMAND[:600], np.full(600, np.nan)), (COMMAND, COMMAND[:9])],
)
def test_what_shows_no_lag_is_an_error(command, measured):
    with pytest.raises(SstlError, match="E416"):
        loop_lag.identify(command, measured, DT)

"""Shares of a controller's stages: an error that was put into one stage comes back as that stage's share."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop, track
from sstl_cli.control.references import sinusoid
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.stages import STAGES, Stream, _believed, _loop_lag, stage_shares
from sstl_cli.physics.filters import first_order

TRUE = Theta(0.583, -1.444, 1.688, -1.043)
NAMES = np.array(["PB", "PP", "RB", "RP", "SAFE"])


def stream(believed: Theta, tau: float = 0.0, extra: float = 0.0) -> Stream:
    reference = sinusoid(0.02)
    done = track(Controller(believed, Options(dt_s=0.02)), Plant(PlayTendon(TRUE), TensionLoop(tau)), reference.tension_n)
    # the rest before the first sample is no part of what is shared out
    keep = slice(1000, None)
    out = done.tension_out + extra * np.sin(2 * np.pi * reference.time_s / 7.0)
    return Stream(
        "s",
        reference.time_s[keep],
        reference.tension_n[keep],
        done.command[keep],
        done.tension_in[keep],
        out[keep],
        NAMES[done.phase[keep]],
    )


@pytest.mark.parametrize(
    ("stage", "made"),
    [
        ("mapping", {"believed": Theta(0.53, -1.444, 1.80, -1.043)}),
        ("bias", {"believed": Theta(0.583, 0.0, 1.688, 0.0)}),
        ("plant", {"believed": TRUE, "extra": 0.3}),
    ],
)
def test_the_wrong_stage_gets_the_largest_share(stage, made):
    found = stage_shares(stream(**made))
    assert sum(found.share_pct.values()) == pytest.approx(100.0)
    assert max(found.share_pct, key=lambda k: found.share_pct[k]) == stage
    assert found.share_pct[stage] > 60.0
    # with no stage right the error is as recorded
    assert found.simulated_rmse_n == pytest.approx(found.rmse_n, rel=0.1)


def test_loop_lag_is_found():
    found = stage_shares(stream(TRUE, tau=0.3))
    assert found.loop_tau_s == pytest.approx(0.3, rel=0.1)
    lag = found.share_pct["loop lag"] + found.share_pct["backlash handling"]
    assert lag > 60.0
    assert set(found.share_pct) == set(STAGES)


def test_too_short_is_an_error():
    s = stream(TRUE)
    short = Stream("s", *(x[:50] for x in (s.time_s, s.reference_n, s.command_n, s.input_n, s.output_n, s.phase)))
    with pytest.raises(SstlError, match="fewer than"):
        stage_shares(short)


def made(command, input_n, phase, dt=0.02):
    """Return a stream whose reference is 0.5 T + 1 while pulling, 2 T - 3 while releasing."""
    reference = np.where(phase == "PP", 0.5 * command + 1.0, 2.0 * command - 3.0)
    return Stream("s", np.arange(len(command)) * dt, reference, command, input_n, reference, phase)


def test_the_lines_behind_the_commands_are_read_from_their_propagation():
    command = np.linspace(1.0, 5.0, 60)
    phase = np.repeat(["PP", "PB", "RP"], 20)
    assert [*vars(_believed(made(command, command, phase))).values()] == pytest.approx([0.5, 1.0, 2.0, -3.0])
    with pytest.raises(SstlError, match="no RP samples"):
        _believed(made(command[:59], command[:59], phase[:59]))
    with pytest.raises(SstlError, match="no PP samples"):
        _believed(made(np.where(phase == "PP", 3.0, command), command, phase))


@pytest.mark.parametrize("tau", [0.0, 0.1, 0.743, 1.99])
def test_a_loop_lag_is_found_to_a_thousandth_of_a_second(tau):
    command = 10.0 + 5.0 * np.sin(np.arange(1000) * 0.02)
    phase = np.repeat("PP", 1000)
    # a grid of 21 points over 2 s, refined twice to a tenth
    assert _loop_lag(made(command, first_order(command, 0.02, tau), phase), 0.02) == pytest.approx(tau, abs=6e-4)


def test_shares_are_of_the_error_as_simulated_and_the_error_is_as_recorded():
    s = stream(TRUE, extra=0.3)
    found = stage_shares(s)
    assert found.run_id == "s" and found.rmse_n == pytest.approx(np.sqrt(np.mean((s.reference_n - s.output_n) ** 2)))
    assert found.simulated_rmse_n == pytest.approx(found.rmse_n, rel=0.1)
    assert [*vars(found.true).values()] == pytest.approx([*vars(TRUE).values()], abs=0.1)

"""Shares of a controller's stages: an error that was put into one stage comes back as that stage's share."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop, track
from sstl_cli.control.references import sinusoid
from sstl_cli.core.errors import SstlError
from sstl_cli.diagnosis.stages import STAGES, Stream, stage_shares

TRUE = Theta(0.583, -1.444, 1.688, -1.043)
NAMES = np.array(["PB", "PP", "RB", "RP", "SAFE"])


def stream(believed: Theta, tau: float = 0.0, extra: float = 0.0) -> Stream:
    reference = sinusoid(0.02)
    done = track(Controller(believed, Options(dt_s=0.02)), Plant(PlayTendon(TRUE), TensionLoop(tau)), reference.tension_n)
    # the rest before the first sample is no part of what is shared out
    keep = slice(1000, None)
    out = done.tension_out + extra * np.sin(2 * np.pi * reference.time_s / 7.0)
    return Stream("s", reference.time_s[keep], reference.tension_n[keep], done.command[keep], done.tension_in[keep], out[keep], NAMES[done.phase[keep]])


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

"""When messages of a robot's log came and when they were sent: by made-up stamps of two topics."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.importers.guess_clocks import clocks_of_channels
from sstl_cli.importers.guess_toml import MARK

USED = ("/in.force", "/out.force")
OWN = {"/in.force": "/in@time", "/out.force": "/out@time"}
T = np.arange(300) * 0.005


def of(in_late: float = 0.001, out_late: float = 0.001, **sent) -> object:
    """Return the clocks of two topics that come so much later (s) than they were sent."""
    data = {"/in@time": T + in_late, "/out@time": T + out_late, "/in.header.stamp": T, "/out.header.stamp": T}
    return clocks_of_channels(OWN, USED, {**data, **sent})


def test_each_side_has_the_clock_of_its_sender():
    found = of()
    assert found.time.channel == "/in.header.stamp" and MARK not in found.time.line
    assert "'/in@time' is when it came" in found.time.reasons[0]
    assert found.own["/out.force"].channel == "/out.header.stamp" and "/in.force" not in found.own


@pytest.mark.parametrize(("out_late", "asks"), [(0.003, False), (0.08, True)])
def test_a_side_that_comes_later_by_more_than_a_step_is_asked(out_late, asks):
    line = of(out_late=out_late).time.line
    assert (MARK in line) is asks and (not asks or "'/out.header.stamp' comes 0.08 s after it was sent" in line)


def test_stamps_that_go_back_are_asked_and_those_that_stand_still_are_none():
    back = T.copy()
    back[::20] -= 0.02
    mixed = {"/in.header.stamp": back}
    found = of(**mixed)
    assert found.time.channel == "/in@time" and "goes back at times" in found.time.line and not found.own
    unset = of(**{"/in.header.stamp": np.zeros(300)})
    assert unset.time.channel == "/in@time" and MARK not in unset.time.line and not unset.own


def test_formats_with_a_clock_of_their_own_for_each_channel_keep_it():
    found = clocks_of_channels({"F": "F/time", "G": "G/time"}, ("F", "G"), {"F/time": T, "G/time": T})
    assert found.time.line == 'time_s = { column = "F/time", unit = "s" }' and not found.own

"""Pulses that a filter lets decay, beside what only looks like one."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.diagnosis.pulses import pulses
from sstl_cli.diagnosis.recorder import scan

NOISE, AT = 0.02, 300
LINE = 10.0 + 4.0 * np.sin(np.linspace(0.0, 9.0, 600)) + NOISE * np.random.default_rng(3).standard_normal(600)


def hit(height, kept, at=AT):
    after = np.maximum(np.arange(600.0) - at, 0.0)
    return LINE + np.where(np.arange(600) >= at, height * kept**after, 0.0)


@pytest.mark.parametrize("height", [0.5, -2.0])
@pytest.mark.parametrize("kept", [0.4, 0.7])
def test_a_decaying_pulse_is_flagged_until_it_is_gone(height, kept):
    found = np.flatnonzero(pulses(hit(height, kept), NOISE))
    gone = np.log(NOISE / abs(height)) / np.log(kept)
    assert found[0] == AT and found.tolist() == list(range(AT, AT + len(found)))
    assert len(found) == pytest.approx(gone, abs=3.0)
    # a recorder that spoils readings so is told by its scan, too
    assert set(found) <= set(np.flatnonzero(scan(hit(height, kept)).spike))


def test_each_of_several_pulses_is_flagged():
    several = hit(0.6, 0.6, 100) + hit(-0.6, 0.6, 220) + hit(1.5, 0.5, 400) - 2.0 * LINE
    assert [int(i) for i in np.flatnonzero(np.diff(pulses(several, NOISE).astype(int)) == 1) + 1] == [100, 220, 400]


@pytest.mark.parametrize(
    "signal",
    [
        LINE,
        LINE + 0.6 * (np.arange(600) >= AT),  # a slip
        LINE + 0.6 * ((np.arange(600) - AT) % 40) / 40.0,  # slips that load again
        LINE + 0.6 * np.exp(-(((np.arange(600) - AT) / 6.0) ** 2)),  # an impact that rises first
        hit(0.1, 0.7),  # too small to be sure
        hit(0.6, 0.99),  # comes back so slowly that the line may have moved
        hit(0.6, 0.7, 2),  # no line before it
    ],
)
def test_what_stays_or_rises_first_is_no_pulse(signal):
    assert not pulses(signal, NOISE).any()


def test_a_pulse_at_the_end_is_not_told():
    assert not pulses(hit(0.6, 0.7, 590), NOISE).any()

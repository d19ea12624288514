"""Records of which a sample of the analysis is a mean over several steps of the simulation: times and frequencies are those of the sample."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from made_sims import sim

from sstl_cli.diagnosis import state, variation, where
from sstl_cli.diagnosis.features import _independent
from sstl_cli.diagnosis.heldout import blocks
from sstl_cli.diagnosis.residuals import _lines, _partitions, _spectrum

DT, FACTOR = 0.1, 4
STEP = DT * FACTOR


def made(u, **labels):
    found = sim((np.repeat(np.asarray(u, float), FACTOR), {"dt_s": DT, "factor": FACTOR, **labels}))
    for r in found.problem.records:
        r.time_s = STEP * (np.arange(len(r)) + 0.5)
    found.edges, found.dispersion = np.array([0, len(found.y)]), {}
    return found


def test_times_since_a_reversal_are_those_of_samples():
    # one way up for sixteen samples of 0.4 s, then down: edges at 0.1, 0.3, 1 and 3 s
    one = made(np.concatenate((np.arange(16.0), 15.0 - np.arange(16.0))))
    since = _partitions(one, np.zeros(32, int))["phase and time since reversal"]
    turn = int(np.flatnonzero(np.diff(np.sign(one.problem.records[0].rate.reshape(-1, FACTOR).mean(axis=1))))[0]) + 1
    expected = np.concatenate([np.searchsorted([0.1, 0.3, 1.0, 3.0], STEP * np.arange(n)) for n in (turn, 32 - turn)])
    # where the rate is nothing at all is a turn of its own
    same = np.arange(32) < turn
    assert since[same].tolist() == expected[same].tolist() and since[turn + 2 :].max() == 4 and since[0] == 0 and since[1] == 2
    assert [b.share_pct for b in where.bands(one, np.where(np.arange(32) == 2, 1.0, 0.0))["time_since_reversal_s"]] == [
        0.0,
        0.0,
        100.0,
        0.0,
        0.0,
        0.0,
    ]


@pytest.mark.parametrize(("hz", "band"), [(0.05, "0-0.1"), (0.2, "0.1-0.5"), (1.0, "0.5-2")])
def test_frequencies_are_those_of_samples(hz, band):
    one = made(np.arange(400.0))
    tone = 9.0 * np.sin(2.0 * np.pi * hz * STEP * np.arange(400) + 0.4)
    assert _spectrum(one, tone, np.ones(400, bool), False).peak == f"{band} Hz"
    line, single = _lines(one, tone, np.ones(400, bool))
    assert line.peak == f"{hz:.3g} Hz in run r0"
    # the largest sample is told by its instant
    at = int(np.argmax(np.abs(tone)))
    assert single.peak == f"{STEP * (at + 0.5):.4g} s of run r0"
    found = {b.low: b.share_pct for b in where.bands(one, tone)["frequency_hz"]}
    assert found[max(low for low in found if low <= hz + 1e-9)] > 90.0


def test_blocks_last_five_seconds_of_samples():
    assert np.bincount(blocks(made(np.zeros(30)))).tolist() == [12, 12, 6]


def test_stretches_are_as_long_as_a_part_of_the_record_and_a_loop():
    one = made(np.tile(np.concatenate((np.arange(20.0), 20.0 - np.arange(20.0))), 10))
    (r,) = one.problem.records
    assert variation._duration_s(r) == pytest.approx(160.0)
    # an eighth of it is 20 s, a loop 16 s: there and back are 19 turns
    assert variation._stretch_s(r) == pytest.approx(20.0)
    few = made(np.concatenate((np.arange(200.0), 200.0 - np.arange(200.0)))).problem.records[0]
    assert variation._stretch_s(few) == pytest.approx(320.0)
    assert [s.stop - s.start for s in variation._cut(r, 20.0)] == [50] * 8


@pytest.mark.parametrize("lasting_s", [0.1, 2.0])
def test_a_known_scatter_says_the_same_for_as_long_as_it_lasts(lasting_s):
    one = made(np.zeros(100), misfit_n=np.full(100, 0.3), misfit_s=lasting_s)
    (r,) = one.problem.records
    r.weight = np.where(np.arange(100) < 80, 1.0, 0.0)
    found = SimpleNamespace(sim=one, noise=SimpleNamespace(output={"act": SimpleNamespace(white_n=0.8)}))
    # white noise of a mean of four is half of it: 0.09 of 0.25 scatters, alike over twice its time less a sample
    share = 0.09 / (0.09 + 0.64 / 4.0)
    expected = 80.0 / (1.0 + share * max(2.0 * lasting_s / STEP - 1.0, 0.0))
    assert _independent(found, 80) == round(expected)


def test_what_is_left_lasts_by_the_speed_of_samples():
    (r,) = made(np.arange(10.0)).problem.records
    r.slip = None
    r.rate = np.tile([1.0, 2.0, 3.0, 2.0], 10)
    assert state.lasting(r, 4.0, 8.0) == pytest.approx([1.0 / (1.0 / 4.0 + 2.0 / 8.0)] * 10)

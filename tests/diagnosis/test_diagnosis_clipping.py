"""A limit of a sensor behind which noise enters, told from a line that rests at its highest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_logs import record
from soon import asked

from sstl_cli.diagnosis.clipping import Limit, Pair, _line, _piled, _resting, limit_of
from sstl_cli.diagnosis.constants import CLIPPED_LEAST, DOUBT_NATS
from sstl_cli.diagnosis.faults import recorder_effects
from sstl_cli.diagnosis.readings import _usual
from sstl_cli.diagnosis.records import prepare

NOISE_N = 0.02
T = 0.01 * np.arange(3000)
CLEAN = {hz: record({}, seed=3, hz=hz, white=0.0) for hz in (50.0,)}


def play(x, wrap=0.4):
    """Return what a tube with dry friction, which may change over time, passes on of an input."""
    out, v = np.empty(len(x)), x[0]
    for k, (u, w) in enumerate(zip(x, np.broadcast_to(wrap, len(x)), strict=True)):
        v = min(max(v, np.exp(-w) * u), np.exp(w) * u)
        out[k] = v
    return out


def moved(top=20.0):
    """Return an input of three tops of which the middle one is lower, and its output (N)."""
    x = np.interp(T, [0, 5, 10, 15, 20, 25, 30], [2, top, 2, 0.8 * top, 2, top, 2])
    return x, play(x)


def read(values, seed, noise=NOISE_N):
    return values + noise * np.random.default_rng(seed).standard_normal(len(values))


def limited(side, share, into=NOISE_N, out=NOISE_N):
    """Return runs of which one channel of the sensing loop is limited before noise enters, and its level (N)."""
    runs = CLEAN[50.0]
    level = share * max(getattr(r, side).max() for r in runs if r.system == "sstl")
    made = []
    for i, r in enumerate(runs):
        x, y = r.tension_in_n, r.tension_out_n
        if r.system == "sstl" and side == "tension_in_n":
            x = np.minimum(x, level)
        if r.system == "sstl" and side == "tension_out_n":
            y = np.minimum(y, level)
        made.append(replace(r, tension_in_n=read(x, 2 * i, into), tension_out_n=read(y, 2 * i + 1, out)))
    return made, level


@pytest.mark.parametrize("side", ["tension_in_n", "tension_out_n"])
@pytest.mark.parametrize("share", asked((0.7, 0.8, 0.95), 0.8))
@pytest.mark.parametrize(("into", "out"), [(0.005, 0.03), (0.03, 0.005)])
def test_readings_that_scatter_about_a_limit_are_left_out(side, share, into, out):
    runs, level = limited(side, share, into, out)
    for r in prepare(runs).records:
        f, other = (r.faults_in, r.faults_out) if side == "tension_in_n" else (r.faults_out, r.faults_in)
        assert not other.clipped.any()
        true = getattr(next(c for c in CLEAN[50.0] if c.run_id == r.run_id), side)[: len(f.clipped)] > level
        if r.system == "act":
            assert not f.clipped.any()
        elif true.any():
            assert f.clip_level_n == pytest.approx(level, abs=0.01)
            assert (
                f.clipped[true].mean() > 0.99 and f.clipped[~true].mean() < 0.05 and not r.raw_weight[: len(true)][true & f.clipped].any()
            )


@pytest.mark.parametrize("again", ["a converter that ends there", "coarse levels"])
def test_readings_below_those_that_repeat_a_limit_are_left_out_with_them(again):
    """Of an amplifier's limit the converter shows the upper half of the noise as one value, or all of it on a few levels."""
    runs, level = limited("tension_out_n", 0.8)
    step = 0.02
    cut = (lambda y: np.minimum(y, level)) if again.startswith("a conv") else (lambda y: step * np.round(y / step))
    for r in prepare([replace(r, tension_out_n=cut(r.tension_out_n)) for r in runs]).records:
        f = r.faults_out
        true = next(c for c in CLEAN[50.0] if c.run_id == r.run_id).tension_out_n[: len(f.clipped)] > level
        if r.system == "sstl" and true.any():
            assert f.clipped[true].mean() > 0.99 and f.clipped[~true].mean() < 0.05


@pytest.mark.parametrize(
    "effects",
    asked(
        (
            {},
            {"presliding": {"breakaway_mm": 0.3}},
            {"stick_slip": {"ratio": 1.3}},
            {"sheath_compliance": {"c_t_per_n": 0.01}},
            {"channel_delay": {"tau_act_s": 0.1, "tau_sstl_s": 0.1}},
            {"channel_lowpass": {"tau_act_s": 0.1}},
            {"zero_drift": {"r_out_act_n": 1.0}},
            {"sensor_nonlinearity": {"a_out": 0.02}},
            {"viscoelastic_creep": {"fraction": 0.3}},
        ),
        {},
        {"channel_delay": {"tau_act_s": 0.1, "tau_sstl_s": 0.1}},
        {"viscoelastic_creep": {"fraction": 0.3}},
    ),
)
def test_a_line_that_rests_at_its_highest_is_at_no_limit(effects):
    for white in (0.005, 0.03):
        for r in prepare(record(effects, seed=3, hz=50.0, white=white)).records:
            assert not r.faults_in.clipped.any() and not r.faults_out.clipped.any()


def test_what_a_limit_took_is_a_candidate_of_the_recorder():
    runs, level = limited("tension_out_n", 0.8)
    records = prepare(runs).records
    # what the line did, without limit and noise
    true = {r.run_id: r.tension_out_n for r in CLEAN[50.0]}
    (effect,) = recorder_effects(records, [true[r.run_id][: len(r.u) * r.thin] for r in records], [NOISE_N] * len(records))
    assert effect.id == "saturation" and effect.share > 0.9 and effect.parameters["t_max_out_n"] == pytest.approx(level, abs=0.01)


def test_the_line_beyond_a_limit_follows_from_where_it_is_not_at_it():
    x, y = moved()
    level = 9.0
    out = Pair(x, read(np.minimum(y, level), 1), NOISE_N, True)
    assert np.sqrt(np.mean((_line(out, y >= level) - y) ** 2)) < 0.2 * NOISE_N
    # where the input is at its limit, the output goes on, and the line begins anew behind it
    into = Pair(np.minimum(x, 15.0), read(y, 1), NOISE_N, False)
    made, there = _line(into, x >= 15.0), x >= 15.0
    assert np.sqrt(np.mean((made - y)[~there] ** 2)) < 2.0 * NOISE_N and (y - made)[there].max() == pytest.approx(
        5.0 * np.exp(-0.4), abs=0.1
    )


def test_a_limit_gains_by_how_far_the_line_goes_beyond_what_it_is_off_elsewhere():
    x, y = moved()
    found = limit_of([Pair(x, read(np.minimum(y, 9.0), 1), NOISE_N, True)])
    (there,) = found.there
    beyond = float(np.mean(y[there] - 9.0))
    assert found.level_n == pytest.approx(9.0, abs=0.002) and found.nats() == pytest.approx(0.5 * (beyond / NOISE_N) ** 2, rel=0.1)
    # the same line where the model of it is off by half a newton elsewhere
    odd = np.minimum(y, 9.0) + np.where(y < 9.0, 0.5 * np.sin(40.0 * T), 0.0)
    assert limit_of([Pair(x, read(odd, 1), NOISE_N, True)]).nats() < found.nats() / 100.0
    # no limit: a true rest at the top is where the line is
    assert limit_of([Pair(x, read(y, 1), NOISE_N, True)]).nats() < 1.0


@pytest.mark.parametrize("is_out", [True, False])
def test_a_limit_takes_what_an_amplifier_compresses_below_it(is_out):
    x, y = moved()
    value, level, width = (y, 9.0, 0.3) if is_out else (x, 15.0, 0.3)
    soft = value - width * np.logaddexp(0.0, (value - level) / width)
    pair = Pair(x, read(soft, 1), NOISE_N, True) if is_out else Pair(read(soft, 1), y, NOISE_N, False)
    found = limit_of([pair])
    assert found.nats() > DOUBT_NATS
    # what is read short by more than noise, and little of the rest; where the input comes down from its limit the output tells nothing
    short = value - soft
    assert found.there[0][short > (3.0 if is_out else 10.0) * NOISE_N].all() and not found.there[0][short < 0.1 * NOISE_N].any()
    # what readings short of nothing are off by is the noise
    assert found.off_n < 2.0 * NOISE_N


def test_a_limit_is_one_level_of_all_runs_of_a_sensor():
    x, y = moved()
    low, free = Pair(x, read(np.minimum(y, 9.0), 1), NOISE_N, True), Pair(x, read(y, 2), NOISE_N, True)
    assert limit_of([low, low]).nats() > DOUBT_NATS
    # another run passes it
    found = limit_of([low, free])
    assert found.nats() < 1.0 and not found.there[0].any()


def test_a_level_is_where_readings_pile_up_below_the_highest_one():
    values = np.concatenate((np.linspace(0.0, 9.0, 200), read(np.full(200, 9.0), 4)))
    assert _piled(values, NOISE_N) == pytest.approx(9.0, abs=0.5 * NOISE_N)
    # the highest of two levels that are far apart, however few
    assert _piled(np.concatenate((values, [12.0, 12.0])), NOISE_N) == 12.0


def test_a_rest_lasts_from_the_first_to_the_last_reading_at_the_level():
    value = np.array([0.0, 8.95, 9.01, 9.0, 9.0, 8.97, 0.0, 8.99, 8.99, 0.0, 9.0, 9.0])
    # two are chance, and what never comes up to the level is below it
    assert np.flatnonzero(_resting(np.concatenate((value, [9.0])), 9.0, NOISE_N)).tolist() == [2, 3, 4, 10, 11, 12]
    assert not _resting(value, 9.0, NOISE_N)[10:].any()
    # ... or a little before and behind
    assert np.flatnonzero(_resting(value, 9.0, NOISE_N, 3.0)).tolist() == [1, 2, 3, 4, 5]
    # a run that is there all of the time says nothing
    assert not _resting(read(np.full(100, 9.0), 1), 9.0, NOISE_N).any()


def test_without_noise_nothing_is_told():
    x, y = moved()
    assert limit_of([Pair(x, np.minimum(y, 9.0), 0.0, True)]).nats() == 0.0


def test_a_line_that_every_sensor_shows_short_at_its_highest_is_at_no_limit():
    # friction that grows towards a turn: short by 1.9 % in one loop, by 1.2 % in the other
    loop, other = Limit(18.3, (), 0.35, 0.048), Limit(16.5, (), 0.2, 0.05)
    assert loop.nats() > DOUBT_NATS > 2.0 > loop.nats(other.share)
    assert _usual(("sstl", True), {("sstl", True): loop, ("act", True): other}) == pytest.approx(np.sqrt(0.2**2 - 0.05**2) / 16.5)
    # one level for both is a limit that they share, and the other end of the line says nothing of this one
    same = Limit(18.2, (), 0.3, 0.05)
    assert _usual(("sstl", True), {("sstl", True): loop, ("act", True): same, ("act", False): other}) == 0.0


def test_a_level_that_a_reading_is_far_beyond_is_no_limit():
    """A line that rests, short of what friction elsewhere gives, at a level in six runs, and goes eight times the noise higher in another."""
    x, y = moved()
    level = 0.8 * float(y.max())
    short = Pair(read(x, 1), read(np.minimum(y, level), 2), NOISE_N, True)
    beyond = Pair(read(x, 3), read(np.minimum(y, level + 8.0 * NOISE_N), 4), NOISE_N, True)
    assert limit_of([short, short]).nats() > DOUBT_NATS
    found = limit_of([*[short] * 6, beyond])
    assert found.level_n == pytest.approx(level, abs=0.001)
    assert found.nats() == 0.0 and not any(t.any() for t in found.there)


@pytest.mark.parametrize("noise", [0.01, 0.03])
@pytest.mark.parametrize("is_out", [True, False])
def test_a_run_that_ends_in_a_rest_at_its_highest_tells_no_limit(noise, is_out):
    """It is never released, so that its line of the release is anybody's guess; nor does a look back within the backlash tell it."""
    x = np.interp(T, [0.0, 1.0, 2.5, 14.0, 16.0, 20.0, 23.0, 30.0], [1.3, 1.4, 19.2, 19.2, 10.1, 10.1, 20.8, 20.8])
    for seed in range(4):
        pair = Pair(read(x, 2 * seed, noise), read(play(x), 2 * seed + 1, noise), noise, is_out)
        assert limit_of([pair]).nats() < DOUBT_NATS


def test_a_run_that_only_comes_down_from_its_highest_tells_no_limit():
    """Nobody knows how far its pull had gone: what a line fitted to the way down makes of it is no evidence."""
    # down by steps, each of which is taken back within the backlash
    x = np.interp(T, np.linspace(0.0, 30.0, 13), [25, 11, 20, 10.5, 21, 9, 17, 7, 14, 6, 12, 5, 10])
    y = np.empty(len(x))
    v = 14.0
    for k, u in enumerate(x):
        v = min(max(v, np.exp(-0.5) * u), np.exp(0.5) * u)
        y[k] = v
    down = Pair(read(x, 1), read(y, 2), NOISE_N, is_out=True)
    assert limit_of([down]).nats() < DOUBT_NATS
    # beside a run that tells, readings of such a one at the same level are at the limit as well
    a, b = moved()
    level = 0.9 * b.max()
    told = limit_of(
        [Pair(read(a, 3), read(np.minimum(b, level), 4), NOISE_N, True), Pair(read(x, 1), read(np.minimum(y, level), 2), NOISE_N, True)]
    )
    assert told.nats() > DOUBT_NATS and abs(told.level_n - level) < NOISE_N and told.there[1].any()


@pytest.mark.parametrize("over_s", [1.0, 2.0, 3.5])
def test_friction_that_falls_towards_the_highest_top_is_no_limit_of_the_input(over_s):
    """It lets the output go beyond the line over the rise as at the top: a `saturation` beyond doubt that was none."""
    x = 6.0 + np.where(T > 22.5, 16.0, 14.0) * (1.0 - np.cos(2.0 * np.pi * T / 7.5))
    wrap = 0.4 - 0.03 * np.clip((T - 26.25 + over_s) / over_s, 0.0, 1.0) * np.clip((30.0 - T) / 2.0, 0.0, 1.0)
    worn = limit_of([Pair(read(x, 1), read(play(x, wrap), 2), NOISE_N, is_out=False)])
    assert worn.there[0].sum() >= CLIPPED_LEAST and worn.nats() < DOUBT_NATS
    held = limit_of([Pair(read(np.minimum(x, 37.5), 1), read(play(x), 2), NOISE_N, is_out=False)])
    assert held.nats() > DOUBT_NATS and held.level_n == pytest.approx(37.5, abs=0.01)

"""Effects put into recordings: each operation against numbers worked by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.blind.inject import OPERATIONS, Injection, half, of_size, put_in
from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Gap, Verdict
from sstl_cli.core.errors import UsageError
from sstl_cli.core.runs import Run
from sstl_cli.steps import blind_inject

TIME = np.arange(6) * 0.1
RUN = Run("a", "act", TIME, np.array([0.0, 2.0, 4.0, 6.0, 4.0, 2.0]), np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0]))


@pytest.mark.parametrize(
    ("effect", "size", "expected"),
    [
        ("zero_offset", 0.5, [0.5, 1.5, 2.5, 3.5, 2.5, 1.5]),
        ("gain_error", 0.1, [0.0, 1.1, 2.2, 3.3, 2.2, 1.1]),
        ("zero_drift", 0.5, [0.0, 1.1, 2.2, 3.3, 2.4, 1.5]),
        # what it read before the run began nobody knows
        ("channel_delay", 0.1, [0.0, 1.0, 2.0, 3.0, 2.0]),
        ("crosstalk", 0.1, [0.0, 1.2, 2.4, 3.6, 2.4, 1.2]),
        # full scale at 2.5 x 3: y + 0.1 y (1 - y / 7.5)
        (
            "sensor_nonlinearity",
            0.1,
            [0.0, 1.0 + 0.1 * 6.5 / 7.5, 2.0 + 0.2 * 5.5 / 7.5, 3.18, 2.0 + 0.2 * 5.5 / 7.5, 1.0 + 0.1 * 6.5 / 7.5],
        ),
    ],
)
def test_operation(effect, size, expected):
    (made,) = put_in([RUN], Injection(effect, size, ""))
    assert made.tension_out_n == pytest.approx(expected)


def test_lowpass_follows_a_ramp_late_by_its_time_constant():
    time = np.arange(400) * 0.01
    (made,) = put_in([Run("r", "act", time, time, 3.0 * time)], Injection("channel_lowpass", 0.2, ""))
    assert made.tension_out_n[-1] == pytest.approx(3.0 * (time[-1] - 0.2), rel=1e-6)


def test_friction_takes_away_both_ways_and_leaves_the_noise():
    time = np.arange(400) * 0.01
    clean = np.interp(time, [0.0, 2.0, 4.0], [0.0, 20.0, 0.0])
    noise = 0.01 * np.random.default_rng(0).standard_normal(400)
    (made,) = put_in([Run("r", "act", time, clean, clean + noise)], Injection("const_friction", 0.5, ""))
    assert made.tension_out_n[100] == pytest.approx(9.5, abs=0.05) and made.tension_out_n[300] == pytest.approx(10.5, abs=0.05)
    # held while the input turns, and not frozen
    assert np.count_nonzero(np.diff(made.tension_out_n) == 0.0) == 0


@pytest.mark.parametrize("effect", sorted(OPERATIONS))
def test_size_moves_the_output_by_the_share(effect):
    rng = np.random.default_rng(0)
    u = np.repeat(np.cumsum(rng.standard_normal(60)), 20)
    u = np.convolve(u, np.full(20, 0.05), mode="same")
    run = Run("a", "act", np.arange(len(u)) * 0.02, u, 0.7 * u)
    (made,) = put_in([run], of_size([run], effect, 0.05))
    same = run.tension_out_n[len(run) - len(made) :]
    moved = float(np.sqrt(np.mean((made.tension_out_n - same) ** 2)))
    assert moved == pytest.approx(0.05 * np.ptp(run.tension_out_n), rel=0.03)


def test_a_delay_between_two_readings_leaves_the_noise():
    rng, time = np.random.default_rng(0), np.arange(4000) * 0.01
    noise = 0.01 * rng.standard_normal(4000)
    (made,) = put_in([Run("r", "act", time, time, 3.0 * time + noise)], Injection("channel_delay", 0.016, ""))
    left = made.tension_out_n - 3.0 * (made.time_s - 0.016)
    assert np.mean(left) == pytest.approx(0.0, abs=1e-3)
    # a mean of two readings, as straight lines between them make it, would have 0.72 of it
    assert np.std(left[5:-5]) == pytest.approx(0.01, rel=0.05)


def test_a_delay_is_of_two_samples_at_least():
    run = Run("a", "act", TIME, RUN.tension_in_n, RUN.tension_out_n)
    assert of_size([run], "channel_delay", 1e-3).size == pytest.approx(0.2)


def test_a_run_shorter_than_the_delay_is_left_out():
    assert put_in([RUN, replace(RUN, run_id="b")], Injection("channel_delay", 2.0, "")) == []


def test_halves_make_the_whole():
    first, second = half(RUN, False), half(RUN, True)
    assert np.array_equal(np.concatenate((first.time_s, second.time_s)), RUN.time_s)


def test_an_effect_without_operation_is_an_error():
    with pytest.raises(UsageError, match="cannot be put into a recording"):
        put_in([RUN], Injection("stribeck", 1.0, ""))


def test_a_named_member_of_a_family_is_in_the_group_that_has_the_family():
    family = "lag: channel_delay | channel_lowpass"
    members = {family: ["channel_delay", "channel_lowpass"]}
    verdict = Verdict(status="ambiguous", effects=[], confidence=None, ambiguity_group=[family], why="", members=members)
    said = DiagnosisDocument.model_construct(verdict=verdict, gap=Gap.model_construct(shrink_pct=None), candidates=[])
    found = [blind_inject._row("log", True, Injection(e, 0.1, ""), said).in_group for e in ("channel_delay", "zero_offset")]
    assert found == [True, False]

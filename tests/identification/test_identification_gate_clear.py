"""Gains that leave nothing but noise, in one run or in all, and beside a zero of the same channel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import lines

from sstl_cli.core.runs import Run
from sstl_cli.identification.gate import remarks


def bend(name: str, theta: float, seed: int, gain: float = 1.0, zero: float = 0.0, low: float = 3.0) -> Run:
    """Return one pass over a bend, the output read with a gain and a zero."""
    t, x = multisine(seed, low, 26.0, seconds=90.0)
    t, x = t[: len(t) // 3], x[::3]
    noise = 0.02 * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(
        f"{name}-{seed}", "act", t, x + noise[0], zero + gain * (play(x, lines(theta)) + noise[1]), config_id=name, trajectory="rand"
    )


@pytest.mark.parametrize("gain", [1.3, 1.35, 2.0, 0.7])
def test_gain_of_one_run_beside_two_others_is_told(gain: float) -> None:
    log = [bend("a", 0.3, 1), bend("a", 0.3, 2), bend("b", 0.5, 3, gain)]
    (said,) = remarks(log)
    assert (said.rule, said.run_ids) == ("gain", ("b-3",))
    assert np.sqrt(said.number) == pytest.approx(gain, rel=0.02)


@pytest.mark.parametrize("gain", [1.14, 1.15, 0.86])
def test_gain_of_a_second_session_is_told(gain: float) -> None:
    first, second = [bend("a", 0.4, s) for s in (1, 2)], [bend("a", 0.4, s, gain) for s in (3, 4)]
    (said,) = remarks([*first, *second])
    assert (said.rule, said.severity, said.run_ids) == ("gain", "remark", ("a-3", "a-4"))
    assert np.sqrt(said.number) == pytest.approx(gain, rel=0.02)


def test_gain_of_another_bend_is_none_of_a_session() -> None:
    # there friction may be another one in one direction
    assert not remarks([*(bend("a", 0.4, s) for s in (1, 2)), *(bend("b", 0.4, s, 1.14) for s in (3, 4))])


@pytest.mark.slow
def test_gain_that_all_runs_have_is_told_beyond_what_sensors_and_directions_make() -> None:
    def log(gain: float) -> list[Run]:
        return [bend(n, theta, s, gain) for n, theta, s in (("a", 0.3, 1), ("a", 0.3, 2), ("b", 0.5, 3))]

    (said,) = remarks(log(1.4))
    assert (said.rule, said.severity, len(said.run_ids)) == ("gain", "remark", 3)
    assert not remarks(log(1.15))
    assert not remarks(log(0.87))


def test_friction_that_differs_by_direction_is_no_gain() -> None:
    def turned(r: Run, theta: float) -> Run:
        pull, release = np.exp(-0.8 * theta), np.exp(1.2 * theta)
        y = play(r.tension_in_n, (float(pull), 0.0, float(release), 0.0))
        return replace(r, tension_out_n=y + 0.02 * np.random.default_rng(9).standard_normal(len(y)))

    log = [(bend("a", 0.3, 1), 0.3), (bend("a", 0.3, 2), 0.3), (bend("b", 1.0, 3), 1.0)]
    assert not remarks([turned(r, theta) for r, theta in log])


@pytest.mark.slow
def test_current_of_a_transmitter_is_told_with_gain_and_zero() -> None:
    log = [bend(n, theta, s, 0.32, 4.0, low=0.2) for n, theta, s in (("a", 0.3, 1), ("a", 0.3, 2), ("b", 0.5, 3))]
    (said,) = remarks(log)
    assert (said.rule, said.severity, len(said.run_ids)) == ("gain", "failure", 3)
    assert "offset of 4" in said.sentence
    assert "gain = 3.1" in said.mend


@pytest.mark.slow
@pytest.mark.parametrize("channel", [0, 1])
def test_volts_of_a_channel_with_a_zero_of_its_own_are_told(channel: int) -> None:
    # 0.05 V/N and 1.2 V at no tension: less than the zero of a sound sensor would be in N
    name = ("tension_in_n", "tension_out_n")[channel]
    log = [bend(n, theta, s, low=0.2) for n, theta, s in (("a", 0.3, 1), ("a", 0.3, 2), ("b", 0.5, 3))]
    (said,) = remarks([replace(r, **{name: 1.2 + 0.05 * getattr(r, name)}) for r in log])
    assert (said.rule, said.severity, len(said.run_ids)) == ("gain", "failure", 3)
    assert f"the {('input', 'output')[channel]} probably has a gain of 0.05 and an offset of 1.2" in said.sentence
    assert said.mend.startswith(name) and "gain = 20" in said.mend and "offset = 1.2" in said.mend


@pytest.mark.slow
@pytest.mark.parametrize("zero", [-0.3, 0.3])
def test_small_zero_beside_a_gain_does_not_tell_the_channel(zero: float) -> None:
    # of the input as of the output: 1.2 N is what sound sensors are off as well
    log = [bend(n, theta, s, 0.25, zero, low=0.2) for n, theta, s in (("a", 0.3, 1), ("a", 0.3, 2), ("b", 0.5, 3))]
    (said,) = remarks(log)
    assert (said.rule, said.severity, len(said.run_ids)) == ("gain", "failure", 3)
    assert "gain = 4 }" in said.mend and "offset" not in said.mend


@pytest.mark.slow
@pytest.mark.parametrize(("gain", "zero"), [(1.15, 2.0), (0.85, -0.1), (1.0, 2.0)])
def test_gain_and_zero_of_sound_sensors_are_not_told(gain: float, zero: float) -> None:
    assert not remarks([bend(n, theta, s, gain, zero) for n, theta, s in (("a", 0.3, 1), ("a", 0.3, 2), ("b", 0.5, 3))])


def creeping(run: Run, by: float = 0.004) -> Run:
    """Return an output that goes on by a part of its span while its input rests or slows down, which is no play."""
    slow, out = run.tension_out_n[0], []
    for v in run.tension_out_n.tolist():
        slow += 0.05 * (v - slow)
        out.append(slow)
    return replace(run, tension_out_n=run.tension_out_n + 8.0 * by * (np.array(out) - run.tension_out_n))


BENDS = (("a", 0.2), ("b", 0.3), ("c", 0.4), ("d", 0.5))


@pytest.mark.parametrize("gain", [1.25, 1.4])
def test_gain_of_some_bends_is_told_where_a_creep_hides_the_noise(gain: float) -> None:
    log = [creeping(bend(n, theta, 10 * k + s, gain if n in "cd" else 1.0)) for k, (n, theta) in enumerate(BENDS) for s in (1, 2)]
    (said,) = remarks(log)
    assert (said.rule, said.severity, said.run_ids) == ("gain", "remark", ("c-21", "c-22", "d-31", "d-32"))
    assert np.sqrt(said.number) == pytest.approx(gain, rel=0.02)
    assert "in the other runs" in said.sentence and "gain = 0." in said.mend
    # of one run beside its own repetition as well
    (alone,) = remarks(
        [creeping(bend(n, theta, 10 * k + s, gain if (n, s) == ("c", 1) else 1.0)) for k, (n, theta) in enumerate(BENDS) for s in (1, 2)]
    )
    assert (alone.rule, alone.run_ids) == ("gain", ("c-21",))


def test_creep_alone_is_no_gain() -> None:
    assert not remarks([creeping(bend(n, theta, 10 * k + s), 0.004 * (1 + k)) for k, (n, theta) in enumerate(BENDS) for s in (1, 2)])


@pytest.mark.slow
def test_friction_that_differs_by_direction_is_no_gain_of_some_bends() -> None:
    def turned(n: str, theta: float, seed: int) -> Run:
        run = bend(n, 0.0, seed)
        y = play(run.tension_in_n, (float(np.exp(-0.8 * theta)), 0.0, float(np.exp(1.2 * theta)), 0.0))
        return replace(run, tension_out_n=y + 0.02 * np.random.default_rng(seed).standard_normal(len(y)))

    # two light bends and two strong ones
    bends = (("a", 0.2), ("b", 0.25), ("c", 1.0), ("d", 1.2))
    assert not [
        r for r in remarks([turned(n, theta, 10 * k + s) for k, (n, theta) in enumerate(bends) for s in (1, 2)]) if r.rule == "gain"
    ]

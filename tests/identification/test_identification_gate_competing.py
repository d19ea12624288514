"""Explanations that compete: the remark that names no cause is silent where another rule explains the run, and a common slip is told as one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import bend, lines, rig

from sstl_cli.core.runs import Run
from sstl_cli.identification import samples
from sstl_cli.identification.gate import remarks


def steps(name: str, theta: float, seed: int) -> Run:
    """Return a bend that is driven from level to level by ramps of 0.3 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 36.0, 0.01)
    levels = rng.uniform(3.0, 24.0, 13)
    x = np.interp(t % 3.0, [0.0, 0.3], [0.0, 1.0]) * (levels[1:][(t // 3.0).astype(int)] - levels[:-1][(t // 3.0).astype(int)])
    x = x + levels[:-1][(t // 3.0).astype(int)]
    noise = 0.02 * rng.standard_normal((2, len(t)))
    return Run(name, "act", t, x + noise[0], play(x, lines(theta)) + noise[1], config_id="a", trajectory="stair")


def swapped(r: Run) -> Run:
    return replace(r, tension_in_n=r.tension_out_n, tension_out_n=r.tension_in_n)


@pytest.mark.slow
def test_swapped_channels_are_told_of_all_runs_and_nothing_else_of_the_rest() -> None:
    log = [swapped(r) for r in (*rig()[:2], steps("steps", 0.6, 4))]
    said = remarks(log)
    assert {r.rule for r in said} == {"swapped"}
    assert set(said[0].run_ids) == {r.run_id for r in log}


def sinusoid(name: str, theta: float, seed: int) -> Run:
    """Return a double pass that turns before its output has gone far."""
    t = np.arange(0.0, 80.0, 0.04)
    x = 15.0 - 11.0 * np.cos(2.0 * np.pi * t / 10.0)
    noise = 0.02 * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(name, "sstl", t, x + noise[0], play(x, lines(theta)) + noise[1], config_id=name, trajectory="sin")


def test_one_sinusoid_of_a_wide_loop_with_its_channels_swapped_is_told() -> None:
    log = [sinusoid(f"b{i}", 0.6 + 0.1 * i, i) for i in range(3)]
    wide = sinusoid("wide", 1.25, 9)
    assert float(np.corrcoef(wide.tension_in_n, wide.tension_out_n)[0, 1]) < 0.2
    (said,) = remarks([*log, swapped(wide)])
    assert (said.rule, said.run_ids) == ("swapped", ("wide",))
    # a sensor that was lost at its highest reading looks like a loop that is never released
    assert "or the input was lost" in said.sentence
    assert "swapped" not in [r.rule for r in remarks([*log, wide])]


@pytest.mark.slow
def test_a_clock_that_drifts_is_no_other_recording() -> None:
    def drifting(r: Run) -> Run:
        late = np.interp(r.time_s / 1.012, r.time_s, r.tension_out_n)
        return replace(r, time_s=r.time_s, tension_out_n=late)

    def repeated(seed: int, theta: float) -> Run:
        t = np.arange(0.0, 110.0, 0.02)
        x = 12.0 + 7.5 * np.sin(2.0 * np.pi * t / 5.5)
        noise = 0.012 * np.random.default_rng(seed).standard_normal((2, len(t)))
        return Run(f"r{seed}", "act", t, x + noise[0], play(x, lines(theta)) + noise[1], config_id="a", trajectory="sine")

    said = remarks([drifting(repeated(1, 0.4)), drifting(repeated(2, 0.4)), repeated(3, 0.4), repeated(4, 0.4)])
    assert "unrelated" not in {r.rule for r in said}


def test_a_gap_that_was_filled_is_no_reference_of_another_run() -> None:
    def filled(r: Run) -> Run:
        keep = (r.time_s < 9.0) | (r.time_s > 16.0)
        x, y = (np.interp(r.time_s, r.time_s[keep], v[keep]) for v in (r.tension_in_n, r.tension_out_n))
        return replace(r, tension_in_n=x, tension_out_n=y)

    log = [replace(r, tension_ref_n=np.convolve(np.pad(r.tension_in_n, 10, mode="edge"), np.ones(21) / 21, "valid")) for r in rig()]
    said = remarks([filled(log[0]), *log[1:]])
    assert {r.rule for r in said} == {"filled"}


@pytest.mark.parametrize("stiffness", [2.0, 6.0])
def test_position_and_reference_exchanged_are_told_as_such_and_not_as_a_unit(stiffness: float) -> None:
    def beside(r: Run) -> Run:
        reference = np.convolve(np.pad(r.tension_in_n, 25, mode="edge"), np.ones(51) / 51, "valid")
        return replace(r, position_in_mm=reference, tension_ref_n=r.tension_in_n / stiffness + 0.2)

    (said,) = remarks([beside(r) for r in rig()])
    assert (said.rule, len(said.run_ids)) == ("reference", 6)
    assert "exchanged" in said.sentence
    assert "ozf" not in said.mend
    right = [replace(r, position_in_mm=r.tension_ref_n, tension_ref_n=r.position_in_mm) for r in map(beside, rig())]
    assert not remarks(right)


def test_a_single_pass_over_a_large_bend_is_no_double_one() -> None:
    def pass_of(theta: float, seed: int) -> Run:
        t, x = multisine(seed, 0.5, 40.0, seconds=90.0)
        t, x = t[: len(t) // 3], x[::3]
        noise = 0.01 * np.random.default_rng(seed).standard_normal((2, len(t)))
        return Run(f"r{seed}", "act", t, x + noise[0], play(x, lines(theta)) + noise[1], config_id="a", trajectory=f"m{seed}")

    assert not remarks([pass_of(0.93, s) for s in (1, 2, 3)])


def repeated(name: str, system: str, theta: float, period: float, seed: int, noise: float = 0.012) -> Run:
    """Return a bend driven by a sine of 9 N about 13 N."""
    t = np.arange(0.0, 20.0, 0.01 / 3.0)
    x = 13.0 + 9.0 * np.sin(2.0 * np.pi * t / period)
    white = noise * np.random.default_rng(seed).standard_normal((2, len(t)))
    wrap = theta * (2 if system == "sstl" else 1)
    return Run(name, system, t, x + white[0], play(x, lines(wrap)) + white[1], config_id="a", trajectory="sine")


def late(r: Run, by_s: float) -> Run:
    k = round(by_s / float(r.time_s[1] - r.time_s[0]))
    return replace(r, time_s=r.time_s[k:], tension_in_n=r.tension_in_n[k:], tension_out_n=r.tension_out_n[: len(r) - k])


def shaken(r: Run) -> Run:
    """Return a recording three times as fast: one that a delay of a second takes far from its input."""
    return replace(r, time_s=r.time_s / 3.0)


@pytest.mark.slow
def test_a_delay_that_all_runs_share_is_told_before_a_sign_or_energy() -> None:
    log = [
        late(r, 1.2)
        for r in (*map(shaken, rig()[:3]), shaken(bend("b080", 0.6, "act", 77, movement=9)), repeated("sine", "act", 0.4, 2.0, 5))
    ]
    said = remarks(log)
    assert [r.rule for r in said] == ["lead"]
    assert said[0].number == pytest.approx(1.2, rel=0.05)
    assert len(said[0].run_ids) == 5


@pytest.mark.slow
def test_an_output_at_another_rate_is_no_other_recording() -> None:
    def doubled(r: Run) -> Run:
        half = len(r) // 2
        return replace(r, time_s=r.time_s[:half], tension_in_n=r.tension_in_n[:half], tension_out_n=r.tension_out_n[::2][:half])

    said = remarks([doubled(r) for r in rig()])
    assert "unrelated" not in {r.rule for r in said}
    told = next(r for r in said if r.rule == "drift")
    assert told.number == pytest.approx(2.0)
    assert len(told.run_ids) >= 4


@pytest.mark.slow
def test_a_label_of_one_run_is_told_though_presliding_hides_its_slopes() -> None:
    def gives(x: np.ndarray, theta: float) -> np.ndarray:
        """Strands that slide one after the other."""
        return np.mean([play(x, lines(theta * k)) for k in np.linspace(0.4, 1.6, 25)], axis=0)

    def run(name: str, system: str, theta: float, seed: int, slides: bool = False) -> Run:
        t, x = multisine(seed, 4.0, 25.0, seconds=90.0)
        t, x = t[: len(t) // 3], x[::3]
        noise = 0.012 * np.random.default_rng(seed).standard_normal((2, len(t)))
        return Run(
            name,
            system,
            t,
            x + noise[0],
            (play(x, lines(theta)) if slides else gives(x, theta)) + noise[1],
            config_id="a",
            trajectory=f"m{seed}",
        )

    log = [run("wrong", "sstl", 0.42, 2), run("b", "act", 0.42, 1, True), run("c", "sstl", 0.9, 3, True), run("d", "sstl", 0.9, 4, True)]
    (said,) = remarks(log)
    assert (said.rule, said.run_ids) == ("passes", ("wrong",))
    assert not remarks([replace(log[0], system="act"), *log[1:]])


def test_a_saturated_input_with_noise_on_its_flat_top_is_told_though_its_rests_are_short() -> None:
    t = np.arange(0.0, 27.0, 0.005)
    x = np.interp(t % 5.4, [0.0, 2.7, 5.4], [2.5, 34.0, 2.5])
    noise = 0.012 * np.random.default_rng(2).standard_normal((2, len(t)))
    y = play(x, lines(0.55)) + noise[1]
    run = Run("r", "act", t, np.minimum(x, 27.0) + noise[0], y, config_id="a", trajectory="tri")
    assert "limit" in {r.rule for r in remarks([run])}
    assert not remarks([replace(run, tension_in_n=x + noise[0])])


def test_rows_of_two_loggers_are_told_as_interleaved_beside_the_label_that_changes() -> None:
    a, b = rig()[0], bend("b080", 0.6, "act", 77, movement=9)
    mixed = {n: np.column_stack([getattr(a, n), getattr(b, n)]).ravel() for n in ("time_s", "tension_in_n", "tension_out_n")}
    mixed["time_s"] = np.arange(len(mixed["time_s"])) * 0.005
    found = samples.findings(samples.Piece("r", mixed, labels={"trajectory": ["sine", "multi"]}))
    (told,) = [f for f in found if f.what.startswith("label changes")]
    assert "interleaved" in told.detail
    whole = {n: getattr(a, n) for n in mixed}
    (plain,) = [f for f in samples.findings(samples.Piece("r", whole, labels={"trajectory": ["sine", "multi"]})) if "label" in f.what]
    assert "interleaved" not in plain.detail


def test_all_runs_of_one_slip_are_listed() -> None:
    log = rig()
    weak = [replace(r, tension_in_n=1e-3 * r.tension_in_n, tension_out_n=1e-3 * r.tension_out_n) for r in log]
    still = replace(weak[0], run_id="still", tension_out_n=weak[0].tension_out_n[::-1].copy())
    named = {name for r in remarks([*weak, still]) if r.rule == "magnitude" for name in r.run_ids}
    assert named == {r.run_id for r in (*log, still)}


def test_two_runs_of_another_rig_are_named_with_the_runs_they_outnumber() -> None:
    def run(name: str, theta: float, seed: int, kind: str) -> Run:
        return replace(bend("a", theta, "act", seed, movement=seed), run_id=name, trajectory=kind)

    log = [run("tri", 0.2, 1, "tri"), run("own", 0.2, 2, "multi"), run("q1", 0.8, 3, "multi"), run("q2", 0.8, 4, "multi")]
    (said,) = [r for r in remarks(log) if r.rule == "labels"]
    assert set(said.run_ids) == {"own", "q1", "q2"}


@pytest.mark.slow
def test_the_absolute_value_of_an_output_is_told_where_the_input_goes_through_zero() -> None:
    r = rig()[2]
    x, y = r.tension_in_n - 12.0, r.tension_out_n - 11.0
    (said,) = [one for one in remarks([replace(r, tension_in_n=x, tension_out_n=np.abs(y))]) if one.failed]
    assert said.rule == "folded"
    assert "absolute value" in said.sentence
    assert "folded" not in {one.rule for one in remarks([replace(r, tension_in_n=x, tension_out_n=y)])}

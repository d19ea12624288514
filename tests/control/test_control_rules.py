"""Parameters, limits and small parts of the controller, worked by hand; inputs on a coarse grid meet every threshold."""

from __future__ import annotations

import math
import os
import threading

import numpy as np
import pytest
from helpers_control import TABLE_II, paper_controller, play, presliding

from sstl_cli.control import benchmark, law, plant, references
from sstl_cli.control.controller import Controller, Options, Theta, fault_text, loop_gain, normalised, pack
from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop, pulled, track
from sstl_cli.control.presliding import fit_widths, play_sum
from sstl_cli.control.sim_plant import plant_of
from sstl_cli.control.streaming import LineServer, read_csv_sample, read_json_sample, read_lines
from sstl_cli.core.errors import SstlError
from sstl_cli.physics.scenario import Scenario

LINES = Theta(*TABLE_II)
EVEN = Theta(0.5, 0.0, 2.0, 0.0)


def coarse(seed: int, n: int = 3000) -> tuple[np.ndarray, np.ndarray]:
    """A reference in whole and a tension in half newtons, so that thresholds are met exactly and not only crossed."""
    rng = np.random.default_rng(seed)
    steps = np.repeat(rng.choice([-1.0, 0.0, 1.0], n // 6), 6)
    reference = np.abs((8.0 + np.cumsum(steps)) % 38.0 - 19.0) + 1.0
    return reference, np.round(2.0 * rng.uniform(0.0, 40.0, n)) / 2.0


@pytest.mark.parametrize("doubled", [True, False])
def test_thresholds_that_are_just_met(doubled: bool) -> None:
    reference, measured = coarse(1)
    wanted, phases = paper_controller(reference, measured, (0.5, 0.0, 2.0, 0.0), doubled)
    c, other = Controller(EVEN, Options(doubled=doubled)), Controller(EVEN, Options(doubled=doubled))
    single = [c.step(a, b) for a, b in zip(reference.tolist(), measured.tolist(), strict=True)]
    assert [v for v, _ in single] == pytest.approx(wanted) and [p for _, p in single] == phases
    command, codes = other.replay(reference, measured)
    assert command.tolist() == [v for v, _ in single]
    assert [["PB", "PP", "RB", "RP"][k] for k in codes] == phases
    np.testing.assert_array_equal(c.state, other.state)


def test_turned_twice_at_one_measured_tension_backlash_is_over() -> None:
    # the threshold is that tension but for rounding, which had decided between 1.60 and 11.82 N
    lines, reference = Theta(0.612813, -0.00308335, 1.6332, -0.00757268), [22.0, 19.5, 19.9, 19.3, 18.9]
    replayed, stepped = set(), set()
    for k in range(40):
        held = np.full(5, 22.04 + k * 4e-15)
        command, codes = Controller(lines).replay(np.array(reference), held)
        c = Controller(lines)
        single = [c.step(ref, t_in) for ref, t_in in zip(reference, held.tolist(), strict=True)]
        assert command.tolist() == [v for v, _ in single]
        replayed.add((round(float(command[3]), 2), *codes.tolist()))
        stepped.add("".join(p for _, p in single))
    assert replayed == {(11.82, law.PP, law.RP, law.PB, law.RP, law.RP)} and stepped == {"PPRPPBRPRP"}


@pytest.mark.parametrize(("short", "phase"), [(0.0, "P"), (0.9, "P"), (1.1, "B")])
@pytest.mark.parametrize("turn", [1, -1])
def test_backlash_is_over_within_the_slack_of_its_threshold(turn: int, short: float, phase: str) -> None:
    # lines 0.5 t and 2 t: turned at 16 N, what is held is 8 or 32 N, which the other line gives at 4 or 64 N
    reference = np.array([10.0, 11.0, 10.5, 10.4]) if turn < 0 else np.array([10.0, 9.0, 9.5, 9.6])
    threshold = 4.0 if turn < 0 else 64.0
    measured = np.array([16.0, 16.0, 16.0, threshold - turn * short * law.SLACK_N])
    c = Controller(EVEN)
    assert [c.step(a, b)[1][1] for a, b in zip(reference.tolist(), measured.tolist(), strict=True)] == ["P", "P", "B", phase]
    assert ["BP"[k % 2] for k in Controller(EVEN).replay(reference, measured)[1]] == ["P", "P", "B", phase]


@pytest.mark.parametrize("options", [{"deadband_n": 1.0}, {"tolerance_n": 0.0, "t_max_n": 19.0}, {"tolerance_n": 0.0, "t_max_n": 32.0}])
def test_replay_meets_limits_as_the_step_does(options: dict[str, float]) -> None:
    reference, measured = coarse(2)
    one, other = Controller(EVEN, Options(**options)), Controller(EVEN, Options(**options))
    command, codes = one.replay(reference, measured)
    single = [other.step(a, b) for a, b in zip(reference.tolist(), measured.tolist(), strict=True)]
    assert command.tolist() == [v for v, _ in single]
    assert [["PB", "PP", "RB", "RP", "SAFE"][k] for k in codes] == [p for _, p in single]
    np.testing.assert_array_equal(one.state, other.state)


def test_a_deadband_must_be_exceeded_and_counts_from_the_extreme() -> None:
    c = Controller(EVEN, Options(deadband_n=1.0))
    seen = [c.step(ref, 20.0)[1][0] for ref in (10.0, 11.0, 12.0, 11.5, 12.5, 11.5, 11.4, 12.4, 12.5)]
    #          start: no direction, 1 N is not more than 1 N; extreme 12.5, then 11.4
    assert "".join(seen) == "PPPPPPRRP"


def test_faults_at_their_limits() -> None:
    p = pack(EVEN, Options(t_max_n=40.0, tolerance_n=1.0))
    # reference -1 to 41 N; measured tension -1 to 1.25 * 40 + 1 N
    for ref, t_in, bits in (
        (-1.0, -1.0, 0), (41.0, 51.0, 0), (-1.01, 5.0, law.REF_OUTSIDE), (41.01, 5.0, law.REF_OUTSIDE), (5.0, -1.01, law.IN_OUTSIDE),
        (5.0, 51.01, law.IN_OUTSIDE), (math.nan, math.inf, law.REF_NOT_FINITE + law.IN_NOT_FINITE), (99.0, 99.0, law.REF_OUTSIDE + law.IN_OUTSIDE),
    ):  # fmt: skip
        assert law.fault_of(p, ref, t_in) == bits
    assert fault_text(law.REF_NOT_FINITE) == "reference lost (not a number)" and fault_text(0) == ""
    assert fault_text(law.IN_OUTSIDE) == "measured tension out of range"
    assert (
        fault_text(law.IN_NOT_FINITE) == "measured tension lost (not a number)" and fault_text(law.REF_OUTSIDE) == "reference out of range"
    )


def test_parameter_vector() -> None:
    o = Options(
        dt_s=0.01, lead_s=0.2, max_rate_n_s=50.0, t_max_n=60.0, hold_s=0.057, ramp_n_s=20.0, band_n=0.3, deadband_n=0.1, doubled=False
    )
    expected = [
        0.583, -1.444, 1.688, -1.043, 1, 0, 0, 60.0, 0.5, 1.0 - math.exp(-0.05), 0.1, 0.3, -1.0, 61.0, -1.0, 76.0, 6, 0.2, 1, 0.2, 1.0,
    ]  # fmt: skip
    assert pack(LINES, o).tolist() == pytest.approx(expected)
    other = pack(LINES, o.model_copy(update={"reversal": "play", "widths": (1.0, 3.0), "lead_s": 0.0, "max_jump_n": 0.1}), compensate=False)
    assert other[[4, 6, 8, 9, 17, 18, 19]].tolist() == [0.0, 1.0, 0.1, 1.0, 0.1, 2.0, 0.0]
    assert other[20:].tolist() == [0.5, 1.5]


def test_bounds_and_widths_of_options() -> None:
    assert Options().step_limit_n() == math.inf and not Options().bounded()
    assert Options(max_rate_n_s=50.0).step_limit_n() == pytest.approx(0.1)
    assert Options(max_rate_n_s=50.0, max_jump_n=0.05).step_limit_n() == 0.05
    assert Options(max_jump_n=0.3).bounded() and not Options(max_jump_n=0.3, max_rate_n_s=9.0).unbounded().bounded()
    assert Options().shares().tolist() == Options(presliding=0.5).shares().tolist() == Options(reversal="play").shares().tolist() == [1.0]
    assert Options(reversal="play", presliding=0.8).shares() == pytest.approx(1 + 0.1 * np.array([-7, -5, -3, -1, 1, 3, 5, 7]))
    assert Options(reversal="play", presliding=0.8, widths=(2.0, 6.0)).shares().tolist() == [0.5, 1.5]
    with pytest.raises(SstlError, match="E403"):
        normalised(np.zeros(3))
    assert loop_gain(0.01, 0.1) == pytest.approx(1 - math.exp(-0.1)) and loop_gain(0.01, 0.0) == 1.0


def test_a_play_as_wide_as_the_pull_line_allows_is_refused() -> None:
    # twice the width at slope 0.5: the line of that play would be level
    wide = Options(reversal="play", widths=(0.0, 2.0))
    with pytest.raises(SstlError, match="E403"):
        pack(EVEN, wide)
    assert pack(Theta(0.51, 0, 2, 0), wide)[20:].tolist() == [0.0, 2.0]
    assert pack(Theta(1.0, 0, 2, 0), Options(reversal="play", widths=(0.0, 0.0, 3.0)))[22] == 3.0
    for lines in ((0.5, 0.0, 0.5, 0.0), (1e-9, 0.0, 1.0, 0.0)):
        assert Theta(*lines).gamma_p == lines[0]
    for lines in ((0.5, 0.0, -1.0, 0.0), (-0.5, 0.0, 1.0, 0.0)):
        with pytest.raises(SstlError, match="E401"):
            Theta(*lines)


def test_rest_tension_stays_in_range() -> None:
    assert Controller(LINES).rest_tension(10.0) == pytest.approx((10 + 1.444) / 0.583)
    assert Controller(LINES).rest_tension(70.0) == 80.0 and Controller(LINES).rest_tension(-5.0) == 0.0
    assert Controller(LINES, compensate=False).rest_tension(10.0) == 10.0
    assert LINES.pull(20.0) == pytest.approx(0.583 * 20 - 1.444)
    assert LINES.without_bias() == Theta(0.583, 0.0, 1.688, 0.0)


def test_a_play_within_its_band_keeps_the_command() -> None:
    c = Controller(EVEN, Options(reversal="play", band_n=0.2))
    assert c.step(10.0, 20.0) == (20.0, "PP")
    assert c.step(10.5, 20.0)[0] == pytest.approx(21.0)
    # released: straight to the line 2 T; then up to 0.2 N below the reference is borne, and no more
    assert c.step(10.4, 21.0) == (pytest.approx(5.2), "RB")
    assert c.step(10.3, 5.1) == (pytest.approx(5.2), "RP")
    assert c.step(10.29, 5.0)[0] == pytest.approx(20.58)
    up = Controller(EVEN, Options(reversal="play", band_n=0.2))
    up.step(10.0, 20.0)
    assert up.step(11.0, 20.0)[0] == pytest.approx(22.0)
    # pulled to 11.5: up to 0.2 N above the reference is borne
    assert up.step(11.4, 23.0) == (pytest.approx(22.0), "PP")
    assert up.step(11.45, 22.9) == (pytest.approx(22.0), "PB")
    assert up.step(11.46, 23.4)[0] == pytest.approx(5.73)
    # a quarter of a newton is met exactly, from both sides, and still borne
    edge = Controller(EVEN, Options(reversal="play", band_n=0.25))
    assert [edge.step(*v)[0] for v in ((10.0, 20.0), (11.0, 20.0), (11.25, 23.0))] == [20.0, 22.0, 22.0]
    edge.reset()
    assert [edge.step(*v)[0] for v in ((10.0, 20.0), (10.5, 20.0), (10.4, 21.0), (10.25, 5.0))] == pytest.approx([20.0, 21.0, 5.2, 5.2])


def loop(
    reference: list[float], noise: list[float] | None = None, start: float = 10.0, gain: float = 1.0, slew: float = 99.0, delay: int = 0
) -> tuple[list[float], list[float]]:
    """Close a loop of the given kind around a controller that passes its reference on."""
    c = Controller(Theta(1, 0, 1, 0), compensate=False)
    n = len(reference)
    command, t_in, phase = np.empty(n), np.empty(n), np.empty(n, np.int8)
    law.close_loop(
        c.vector, c.state, np.array(reference), np.array(noise or [], float), law.Loop(start, gain, slew, delay), command, t_in, phase
    )
    return command.tolist(), t_in.tolist()


def test_the_tension_loop() -> None:
    assert loop([12.0, 14.0, 9.0])[1] == [12.0, 14.0, 9.0]
    assert loop([12.0, 14.0, 9.0], gain=0.5)[1] == [11.0, 12.5, 10.75]
    assert loop([12.0, 14.0, 9.0], slew=1.0)[1] == [11.0, 12.0, 11.0]
    assert loop([12.0, 14.0, 9.0], delay=1)[1] == [10.0, 12.0, 14.0]
    assert loop([12.0, 14.0, 9.0], delay=2)[1] == [10.0, 10.0, 12.0]
    # noise of the sensor is seen, not suffered: 200 N too much is a fault
    assert loop([12.0, 14.0, 9.0], noise=[0.0, 200.0, 0.0]) == ([12.0, 12.0, 11.98], [12.0, 12.0, 11.98])


def test_track_and_replay() -> None:
    reference = 10 + 5 * np.sin(np.arange(200) * 0.2)
    p = Plant(PlayTendon(EVEN), TensionLoop(tau_s=0.01, slew_n_s=2000.0, delay_s=0.004, noise_n=0.5))
    done = track(Controller(EVEN), p, reference, np.random.default_rng(1))
    c = Controller(EVEN)
    command, t_in, phase = np.empty(200), np.empty(200), np.empty(200, np.int8)
    noise = 0.5 * np.random.default_rng(1).standard_normal(200)
    law.close_loop(c.vector, c.state, reference, noise, law.Loop(20.0, 1 - math.exp(-0.2), 4.0, 2), command, t_in, phase)
    assert done.command == pytest.approx(command) and done.tension_in == pytest.approx(t_in) and np.array_equal(done.phase, phase)
    quiet = track(Controller(EVEN), p, reference)
    assert not np.array_equal(quiet.command, done.command)
    again = plant.replay(Controller(EVEN), p, reference, t_in)
    wanted, _ = paper_controller(reference, t_in, (0.5, 0, 2, 0))
    assert again.command == pytest.approx(wanted) and again.tension_in is t_in
    assert again.tension_out == pytest.approx(play(wanted, (0.5, 0.0, 2.0, 0.0), 0.5 * wanted[0]))


def test_the_pre_pull_has_500_samples() -> None:
    seen: list[np.ndarray] = []

    def tendon(tension: np.ndarray, dt_s: float) -> np.ndarray:
        seen.append(tension)
        return tension

    assert pulled(tendon, np.array([7.0, 8.0]), 10.0, 0.002).tolist() == [7.0, 8.0]
    assert seen[0][:500] == pytest.approx(np.arange(500) * 10.0 / 499)
    assert PlayTendon(EVEN)(np.array([20.0, 4.0]), 0.1).tolist() == [10.0, 8.0] and PlayTendon(EVEN)(np.empty(0), 0.1).size == 0


SCENARIO = {
    "schema": "sstl.scenario/1",
    "noise": {"white_n": 0.04},
    "configurations": [{"id": "L", "act": dict(zip(("gamma_p", "beta_p", "gamma_r", "beta_r"), TABLE_II, strict=True))}, {"id": "T", "theta": 0.5},
                       {"id": "S", "sstl": {"gamma_p": 0.2, "beta_p": 0.0, "gamma_r": 3.0, "beta_r": 0.0}}],
    "effects": {"tension_loop_lag": {"inverse_slew_s_per_n": 0.02}, "const_friction": {"w_l_n": 0.3}},
}  # fmt: skip


def test_plants_of_a_scenario() -> None:
    scenario = Scenario.model_validate(SCENARIO)
    lines = plant_of(scenario, "L")
    assert lines.tendon == PlayTendon(LINES)
    assert lines.loop == TensionLoop(0.0, 50.0, noise_n=0.04)
    bent = plant_of(scenario, "T", TensionLoop(0.3))
    assert bent.loop == TensionLoop(0.3) and not isinstance(bent.tendon, PlayTendon)
    # slope exp(-0.5), less the friction of the straight parts and of the arc that decays through the bend
    out = bent.tendon(np.linspace(0.0, 20.0, 50), 0.1)[-1]
    decay = math.exp(-0.5)
    assert out == pytest.approx((20.0 - 0.3 * 0.375) * decay - 0.3 * 0.25 * (1 - decay) / 0.5 - 0.3 * 0.375, rel=1e-6)
    with pytest.raises(SstlError, match="does not describe"):
        plant_of(scenario, "S")
    free = Scenario.model_validate(SCENARIO | {"effects": {}})
    assert plant_of(free, "T").loop == TensionLoop(0.0, math.inf, noise_n=0.04)


def test_play_sum_and_fit_of_rounded_loops() -> None:
    tension = 14 + 11 * np.sin(np.arange(600) * 0.05) * np.cos(np.arange(600) * 0.013)
    shares = (0.5, 1.5)
    expected = presliding(tension.tolist(), TABLE_II, shares, tension[0])
    assert play_sum(tension, np.array(shares), *TABLE_II) == pytest.approx(expected)
    assert fit_widths(LINES, tension, np.array(expected), plays=2) == pytest.approx(shares, abs=1e-3)
    assert len(fit_widths(LINES, tension, np.array(expected))) == 8
    ten = fit_widths(LINES, tension[:600:60], np.array(expected)[:600:60], plays=2)
    assert np.mean(ten) == pytest.approx(1.0, abs=0.05)
    with pytest.raises(SstlError, match="E415"):
        fit_widths(LINES, tension[:9], tension[:9])
    # no play may be wider than leaves 2 % of a rising pull line: 0.98 / (1 - 0.583)
    wide = presliding(tension.tolist(), TABLE_II, (0.0, 0.0, 3.0), tension[0])
    assert max(fit_widths(LINES, tension, np.array(wide), plays=3)) == pytest.approx(0.98 / 0.417, rel=1e-6)


def test_a_long_loop_is_thinned_to_4000_samples() -> None:
    # every third of 8001 samples is sound, the others would spoil the fit
    tension = 14 + 11 * np.sin(np.arange(2667) * 0.01)
    out = np.array(presliding(tension.tolist(), TABLE_II, (0.5, 1.5), tension[0]))
    long_in, long_out = np.zeros(8001), np.zeros(8001)
    long_in[::3], long_out[::3] = tension, out
    assert fit_widths(LINES, long_in, long_out, plays=2) == pytest.approx((0.5, 1.5), abs=1e-3)


def server(**options: float) -> tuple[LineServer, list[str]]:
    said: list[str] = []
    return LineServer(Controller(EVEN, Options(**options)), said.append), said


def test_a_stream_counts_lines_and_faults() -> None:
    s, said = server()
    assert s.answer(" T_ref , t_in ") == "t_cmd,phase"
    assert s.answer("10,20") == "20.0,PP" and (s.lines, s.faulty_samples, said) == (2, 0, [])
    assert s.answer("10").endswith("SAFE") and s.answer("10").endswith("SAFE")
    assert s.answer("").endswith("SAFE")
    s.answer("10,20")
    assert s.faulty_samples == 3
    assert said == [
        "line 3: 1 values instead of 2: holding, then ramping down", "line 5: empty line: holding, then ramping down",
        "line 6: input sound again: returning at the ramp's rate",
    ]  # fmt: skip
    assert s.answer('{"t_ref": 10, "t_in": 20}') == '{"t_cmd": 20.0, "phase": "PP"}'
    # an empty line keeps the form of the one before
    assert '"phase": "SAFE"' in s.answer("")


def test_a_line_that_cannot_be_read_is_answered_in_the_form_of_its_stream() -> None:
    s, said = server()
    s.answer('{"t_ref": 10, "t_in": 20}')
    # a lost beginning, an array, a number, a word
    for line in ('ref": 10, "t_in": 20}', "[10, 20]", "10", "nonsense"):
        assert '"phase": "SAFE"' in s.answer(line)
    assert said == ["line 2: not valid JSON: holding, then ramping down", "line 3: not a JSON object: holding, then ramping down",
                    "line 5: not valid JSON: holding, then ramping down"]  # fmt: skip
    # a line of the other form changes it, and so does one that can only be of it
    assert s.answer("10,20").endswith(",PP") and s.answer('"10","20"').endswith(",SAFE")
    assert s.answer('{"t_ref": 10').startswith('{"t_cmd"')
    fresh, _ = server()
    assert fresh.answer("[10, 20]").startswith('{"t_cmd"')


def test_silence_counts_as_samples_without_a_number() -> None:
    s, said = server(dt_s=0.01, hold_s=0.03, ramp_n_s=10.0)
    s.answer("10,20")
    # 0.1 s are 10 samples: 3 of them hold, 7 go down by 0.1 N
    assert float(s.silence(0.1).split(",")[0]) == pytest.approx(19.3) and said == [
        "line 1: no line arrived in time: holding, then ramping down"
    ]
    assert float(s.silence(0.001).split(",")[0]) == pytest.approx(19.2)


def test_lines_are_cut_where_they_grow_too_long() -> None:
    reader, writer = os.pipe()
    thread = threading.Thread(target=lambda: (os.write(writer, b"a" * 65_537 + b"\nshort\nlast" + b"b" * 65_600), os.close(writer)))
    thread.start()
    found = list(read_lines(reader))
    thread.join()
    os.close(reader)
    assert [(line[:4], len(line)) for line in found if line is not None] == [("aaaa", 65_536), ("shor", 5), ("last", 65_536)]


def test_a_line_without_friction_has_widths_up_to_ten() -> None:
    # a pull line of slope 1 bears any width: nine plays of none and one of ten times the mean
    lines = (1.0, -2.0, 1.4, 0.5)
    tension = 14 + 11 * np.sin(np.arange(400) * 0.05) * np.cos(np.arange(400) * 0.013)
    out = presliding(tension.tolist(), lines, (0.0,) * 11 + (12.0,), tension[0])
    assert max(fit_widths(Theta(*lines), tension, np.array(out), plays=12)) == pytest.approx(10.0, rel=1e-6)


def test_samples_of_lines() -> None:
    assert read_csv_sample("1,2") == (1.0, 2.0, "")
    assert read_csv_sample("1,x")[2] == "a value is not a number" and read_csv_sample("1,2,3")[2] == "3 values instead of 2"
    assert read_csv_sample("")[2] == "empty line"
    assert read_json_sample('{"t_ref": 1, "t_in": 2.5}') == (1.0, 2.5, "")
    assert read_json_sample('{"t_ref": 1, "t_in": true}')[2] == "t_in is not a number"
    assert read_json_sample('{"t_ref": 1' + "0" * 400 + ', "t_in": 2}')[0] == math.inf
    assert math.isnan(read_json_sample('{"t_in": 2}')[0])


def test_latency_with_a_clock_of_known_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    # 1000 calls of 10 us, 80 of them of 30 us, one of 200 us
    spent = [10_000] * 919 + [30_000] * 80 + [200_000]
    ticks = iter([t for k, s in enumerate(spent) for t in (k * 10**6, k * 10**6 + s)])
    monkeypatch.setattr(benchmark.time, "perf_counter_ns", lambda: next(ticks))
    monkeypatch.setattr(benchmark, "sinusoid", lambda cycles: references.sinusoid(dt_s=0.1 * cycles, cycles=1))
    found = benchmark.python_latency(cycles=1)
    assert (found.median_us, found.max_us) == (10.0, 200.0) and found.below_20_us_pct == pytest.approx(91.9)
    assert found.p99_us == 30.0 and found.p999_us == pytest.approx(30.17, abs=0.01)
    assert found.counts == (0, 0, 0, 0, 0, 0, 919, 80, 0, 1)
    assert found.edges_us == (0.0, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, math.inf)
    assert benchmark.TABLE_II == LINES
    with pytest.raises(SstlError, match="E414"):
        benchmark.c_step_ns(steps=10, compiler="no-such-compiler")

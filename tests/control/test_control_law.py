"""The controller against hand-worked cases, an independent Algorithm 1, and the properties it must have."""

import numpy as np
import pytest
from helpers_control import TABLE_II, paper_controller, play, presliding
from hypothesis import given, settings
from hypothesis import strategies as st

from sstl_cli.control.controller import Controller, Options, Theta, pack
from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop, pulled, track
from sstl_cli.control.presliding import fit_widths
from sstl_cli.control.references import random, sinusoid, trapezoid
from sstl_cli.control.scoring import score, windows
from sstl_cli.core.errors import SstlError

LINES = Theta(*TABLE_II)
slopes = st.tuples(st.floats(0.3, 0.95), st.floats(-3, 1), st.floats(1.05, 3.0), st.floats(-3, 1)).map(
    lambda v: (v[0], v[1], v[2], max(v[3], v[1]))
)


def steady(reference, output):
    window = windows(reference.time_s, reference.cycle_s)["without first cycle"]
    s = score(reference.tension_n[window], output[window])
    return s.rmse_n, s.std_n, s.mape_pct


def driven(theta, lines, reference, tau=0.0, compensate=True, **options):
    plant = Plant(PlayTendon(Theta(*lines)), TensionLoop(tau))
    return track(Controller(theta, Options(**options), compensate), plant, reference.tension_n)


@pytest.mark.parametrize(("method", "expected"), [("none", (4.45, 3.54, 33.4)), ("no-bias", (1.26, 0.19, 14.1)), ("DI", (0.0, 0.0, 0.0))])
def test_table_ii_with_an_ideal_loop_gives_the_known_numbers(method, expected):
    theta = LINES.without_bias() if method == "no-bias" else LINES
    reference = sinusoid()
    done = driven(theta, TABLE_II, reference, compensate=method != "none")
    assert steady(reference, done.tension_out) == pytest.approx(expected, abs=0.05)


def test_mapping_error_of_table_iii_costs_017_newton():
    reference = sinusoid()
    # Total 0.0166 and Gamma_r 0.0214 (Table III) leave 0.0097 for Gamma_p
    theta = Theta(0.583 + 0.00965, -1.444, 1.688 + 0.0214, -1.043)
    assert steady(reference, driven(theta, TABLE_II, reference).tension_out)[0] == pytest.approx(0.17, abs=0.01)


def test_settings_that_explain_table_iv_give_its_first_two_rows():
    lines, reference = (0.55, -2.8, 1.74, -1.45), sinusoid(amplitude_n=6.0, offset_n=8.1)
    none = driven(Theta(*lines), lines, reference, tau=0.3, compensate=False)
    no_bias = driven(Theta(*lines).without_bias(), lines, reference, tau=0.3)
    assert steady(reference, none.tension_out) == pytest.approx((5.67, 3.65, 46.3), abs=0.03)
    assert steady(reference, no_bias.tension_out) == pytest.approx((2.24, 0.70, 35.5), abs=0.04)


def test_first_movement_down_is_no_reversal():
    c = Controller(LINES)
    first = c.step(10.0, 19.0)
    assert first == (pytest.approx((10 + 1.444) / 0.583), "PP")
    assert c.step(9.9, 19.6) == (pytest.approx((9.9 + 1.043) / 1.688), "RP")


def test_reversal_holds_the_output_and_doubles_the_error():
    c = Controller(Theta(0.5, 0.0, 2.0, 0.0))
    c.step(9.0, 20.0)
    c.step(10.0, 20.0)
    # T_out_rev = 0.5 * 20 = 10; command (2 * 9.5 - 10) / 2; threshold 10 / 2
    assert c.step(9.5, 20.0) == (4.5, "RB")
    assert c.step(9.5, 6.0) == (4.5, "RB")
    assert c.step(9.5, 5.0) == (4.75, "RP")


def test_flat_reference_keeps_the_direction():
    c = Controller(LINES)
    for ref in (10.0, 10.1, 10.1, 10.1):
        command, phase = c.step(ref, 20.0)
    assert (command, phase) == (pytest.approx((10.1 + 1.444) / 0.583), "PP")


def test_reversal_inside_backlash_keeps_the_held_output():
    c = Controller(Theta(0.5, 0.0, 2.0, 0.0))
    c.step(9.0, 18.0)
    c.step(10.0, 20.0)
    assert c.step(9.8, 20.0)[1] == "RB"
    # up again before the release line: T_out_rev stays 10, so the pull threshold is 20
    assert c.step(9.9, 12.0) == (pytest.approx((2 * 9.9 - 10.0) / 0.5), "PB")
    assert c.step(10.1, 19.9)[1] == "PB"
    assert c.step(10.2, 20.0) == (pytest.approx(20.4), "PP")


@settings(max_examples=60, deadline=None)
@given(slopes, st.lists(st.floats(0, 30), min_size=2, max_size=60), st.integers(0, 2**32 - 1), st.booleans())
def test_step_agrees_with_an_independent_algorithm_1(lines, reference, seed, doubled):
    measured = np.random.default_rng(seed).uniform(0, 60, len(reference)).round(2)
    wanted, phases = paper_controller(reference, measured, lines, doubled)
    c = Controller(Theta(*lines), Options(doubled=doubled))
    for k, (t_ref, t_in) in enumerate(zip(reference, measured, strict=True)):
        command, phase = c.step(t_ref, t_in)
        assert (command, phase) == (pytest.approx(wanted[k], abs=1e-9), phases[k])


@settings(max_examples=30, deadline=None)
@given(slopes, st.integers(0, 2**31), st.sampled_from(["paper", "play"]))
def test_propagation_is_inverted_exactly(lines, seed, reversal):
    reference = random(np.random.default_rng(seed), dt_s=0.02, duration_s=100.0, low_n=6.0, high_n=20.0).tension_n
    options = Options(reversal=reversal, t_max_n=500.0, dt_s=0.02)
    done = track(Controller(Theta(*lines), options), Plant(PlayTendon(Theta(*lines))), reference)
    start = lines[0] * done.tension_in[0] + lines[1]
    expected = np.array(play(done.tension_in, lines, start))
    np.testing.assert_allclose(done.tension_out, expected, atol=1e-9)
    propagating = (done.phase == 1) | (done.phase == 3)
    # the sample after a reversal may still be answered in backlash
    assert propagating.mean() > 0.9
    np.testing.assert_allclose(expected[propagating], reference[propagating], atol=1e-6)


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 2**31), st.floats(5, 300), st.floats(0.01, 5), st.floats(0, 0.5), st.sampled_from(["paper", "play"]), st.floats(20, 80)
)
def test_command_stays_within_its_bounds(seed, rate, jump, lead, reversal, t_max):
    rng = np.random.default_rng(seed)
    options = Options(max_rate_n_s=rate, max_jump_n=jump, lead_s=lead, reversal=reversal, t_max_n=t_max, presliding=rng.uniform(0, 1))
    n = 400
    reference = rng.uniform(0, t_max, n)
    measured = rng.uniform(0, t_max, n)
    for values in (reference, measured):
        values[rng.integers(0, n, 20)] = rng.choice([np.nan, np.inf, -np.inf, 1e9, -50.0], 20)
    c = Controller(LINES, options)
    commands = np.array([c.step(a, b)[0] for a, b in zip(reference, measured, strict=True)])
    assert np.isfinite(commands).all()
    assert commands.min() >= 0.0 and commands.max() <= t_max
    # before the first sound sample the command is 0; bounds count from the tension found there
    inputs = np.array([reference, measured])
    sound = np.flatnonzero(np.all((inputs >= 0) & (inputs <= t_max), axis=0))[0]
    assert np.abs(np.diff(commands[sound:])).max() <= min(rate * 0.002, jump) + 1e-9


@pytest.mark.parametrize("options", [{}, {"reversal": "play"}, {"reversal": "play", "presliding": 0.5, "lead_s": 0.1}])
def test_streaming_gives_the_samples_of_the_offline_run(options):
    reference = random(np.random.default_rng(3), duration_s=20.0).tension_n
    c = Controller(LINES, Options(**options))
    done = track(c, Plant(PlayTendon(LINES), TensionLoop(0.1, noise_n=0.02)), reference, np.random.default_rng(4))
    noise = np.random.default_rng(4).standard_normal(len(reference)) * 0.02
    live = Controller(LINES, Options(**options))
    before = np.concatenate(([live.rest_tension(reference[0])], done.tension_in[:-1]))
    answers = [live.step(a, b) for a, b in zip(reference.tolist(), (before + noise).tolist(), strict=True)]
    assert [a for a, _ in answers] == done.command.tolist()
    assert [("PB", "PP", "RB", "RP", "SAFE").index(p) for _, p in answers] == done.phase.tolist()


@pytest.mark.parametrize("spread", [0.3, 0.9])
def test_presliding_inverse_follows_a_rounded_loop(spread):
    shares = [1 + spread * ((j + 0.5) / 8 * 2 - 1) for j in range(8)]
    reference = sinusoid(frequency_hz=0.05)

    def rounded(tension_in, dt_s):
        return np.array(presliding(tension_in.tolist(), TABLE_II, shares, tension_in[0]))

    def rmse(**options):
        done = track(Controller(LINES, Options(**options)), Plant(rounded), reference.tension_n)
        return steady(reference, done.tension_out)[0]

    assert rmse(reversal="play", presliding=spread) < 1e-3
    assert rmse() > 0.1


def test_lead_undoes_the_lag_of_the_tension_loop():
    reference = random(np.random.default_rng(1))
    late = driven(LINES, TABLE_II, reference, tau=0.3)
    leading = driven(LINES, TABLE_II, reference, tau=0.3, lead_s=0.3)
    assert steady(reference, late.tension_out)[0] > 0.5
    assert steady(reference, leading.tension_out)[0] < 0.05


def noisy(tau, **options):
    reference = random(np.random.default_rng(1))
    plant = Plant(PlayTendon(LINES), TensionLoop(tau, noise_n=0.02))
    done = track(Controller(LINES, Options(**options)), plant, reference.tension_n, np.random.default_rng(0))
    return steady(reference, done.tension_out)[0]


@pytest.mark.parametrize(("tau", "reversal"), [(0.25, "paper"), (0.3, "paper"), (0.3, "play"), (0.4, "paper")])
def test_lead_bears_a_wrong_lag_and_sensor_noise(tau, reversal):
    assert noisy(tau, lead_s=0.3, reversal=reversal) < 0.06
    assert noisy(tau) > 0.5


def test_without_its_observer_a_wrong_lead_overshoots():
    assert noisy(0.25, lead_s=0.3, observer=0.0) > 1.0


def test_bounded_lead_does_not_overshoot():
    reference = random(np.random.default_rng(1))
    bounded = driven(LINES, TABLE_II, reference, tau=0.3, lead_s=0.3, max_rate_n_s=50.0)
    assert steady(reference, bounded.tension_out)[0] < 0.3
    slow = driven(LINES, TABLE_II, reference, tau=0.3, max_rate_n_s=50.0)
    assert steady(reference, bounded.tension_out)[0] < 0.5 * steady(reference, slow.tension_out)[0]


def test_doubled_term_crosses_backlash_sooner_behind_a_lag():
    reference = trapezoid(low_n=5, high_n=25)

    def samples(doubled):
        done = driven(LINES, TABLE_II, reference, tau=0.3, doubled=doubled)
        return int(((done.phase == 0) | (done.phase == 2)).sum())

    assert samples(True) < samples(False)


def test_loss_of_input_holds_then_ramps_down_and_returns():
    options = Options(hold_s=0.01, ramp_n_s=10.0)
    c = Controller(LINES, options)
    command, _ = c.step(10.0, 19.6)
    lost = [c.step(10.0, float("nan")) for _ in range(8)]
    assert c.fault == "measured tension lost (not a number)"
    assert [phase for _, phase in lost] == ["SAFE"] * 8
    assert [v for v, _ in lost[:5]] == [command] * 5
    assert [v for v, _ in lost[5:]] == pytest.approx([command - 0.02, command - 0.04, command - 0.06])
    # back at the ramp's rate, not with a jump
    assert c.step(12.0, 19.6)[0] == pytest.approx(command - 0.04)
    assert c.fault == ""
    for _ in range(5000):
        c.step(float("inf"), -400.0)
    assert c.fault == "reference lost (not a number); measured tension out of range"
    assert c.step(float("nan"), 1.0) == (0.0, "SAFE")


def test_tension_loop_answers_a_step_in_closed_form():
    theta, loop = Theta(1.0, 0.0, 1.0, 0.0), TensionLoop(0.1, delay_s=0.01)
    reference = np.full(200, 20.0)
    reference[0] = 10.0
    done = track(Controller(theta, Options(), compensate=False), Plant(PlayTendon(theta), loop), reference)
    time = np.arange(200) * 0.002
    # the step is commanded at sample 1, acts 5 samples later, and is exact at the sampling instants
    expected = np.where(time < 0.012, 10.0, 20.0 - 10.0 * np.exp(-(time - 0.010) / 0.1))
    np.testing.assert_allclose(done.tension_in, expected, atol=1e-9)


def test_pre_pull_puts_the_output_on_the_pull_line():
    out = pulled(PlayTendon(LINES), np.array([20.0, 19.0, 21.0]), 20.0, 0.002)
    assert out.tolist() == pytest.approx([0.583 * 20 - 1.444, 0.583 * 20 - 1.444, 0.583 * 21 - 1.444])


@pytest.mark.parametrize("lines", [(0.0, 0, 1, 0), (0.5, float("nan"), 2, 0), (0.5, 0, float("inf"), 0)])
def test_lines_without_meaning_are_refused(lines):
    with pytest.raises(SstlError, match="E401"):
        Theta(*lines)


def test_exchanged_lines_are_refused():
    with pytest.raises(SstlError, match="E402"):
        Theta(2.0, 0.0, 0.5, 0.0)


def test_presliding_wider_than_the_line_allows_is_refused():
    with pytest.raises(SstlError, match="E403"):
        pack(Theta(0.3, 0.0, 3.0, 0.0), Options(reversal="play", presliding=1.0))


def test_fitted_widths_are_those_that_made_the_loop():
    made = (0.2, 0.7, 1.0, 1.2, 1.9)
    tension_in = 14 + 11 * np.sin(np.arange(4000) * 0.01) * np.cos(np.arange(4000) * 0.0027)
    tension_out = np.array(presliding(tension_in.tolist(), TABLE_II, made, tension_in[0]))
    assert fit_widths(LINES, tension_in, tension_out, plays=5) == pytest.approx(made, abs=0.02)
    plant = Plant(lambda t, dt_s: np.array(presliding(t.tolist(), TABLE_II, made, t[0])))
    reference = sinusoid(frequency_hz=0.05)
    done = track(Controller(LINES, Options(reversal="play", widths=made)), plant, reference.tension_n)
    assert steady(reference, done.tension_out)[0] < 1e-3


@pytest.mark.parametrize("tension", [np.ones(5), np.full(50, np.nan)])
def test_a_loop_that_cannot_be_fitted_is_refused(tension):
    with pytest.raises(SstlError, match="E415"):
        fit_widths(LINES, tension, tension)

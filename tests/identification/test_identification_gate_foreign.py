"""Signals that belong to another recording (noise, another movement, another run's output, two bends in one run), another zero, and much friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import lines
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate.parted import parted_of

N = 4000
T = np.arange(N) / 100.0


def moving(seed, wrap=0.5, top=25.0, noise=1e-3, movement=1, zero=0.0, **labels):
    """Return a run of an ideal capstan; runs of one ``movement`` go the same way."""
    rng = np.random.default_rng(movement)
    w = sum(rng.normal() * np.sin(2.0 * np.pi * f * T + rng.uniform(0.0, 6.28)) for f in rng.uniform(0.05, 0.3, 9))
    x = top * (0.1 + 0.9 * (w - w.min()) / np.ptp(w))
    scatter = top * noise * np.random.default_rng(100 + seed).standard_normal((2, N))
    return Run(f"r{seed}", "act", T, x + scatter[0], play(x, lines(wrap)) + zero + scatter[1], **labels)


def rules(runs):
    return [r.rule for r in gate.remarks(runs)]


@pytest.mark.each_once
@pytest.mark.parametrize("share", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("seed", asked(range(3), 0, 2))
def test_an_input_that_is_but_noise_moves_no_output(seed, share):
    r = moving(seed, movement=seed)
    x = np.random.default_rng(seed).standard_normal(N) * share * np.std(r.tension_in_n) + np.mean(r.tension_in_n)
    said = gate.remarks([replace(r, tension_in_n=x), moving(8, movement=seed), moving(9, movement=seed)])
    assert said[0].rule in ("unrelated", "odd_run") and said[0].run_ids == (r.run_id,) and "unrelated" in [s.rule for s in said]
    assert not {"zero", "time_unit"} & {s.rule for s in said}
    assert "noise about a constant" in next(s.sentence for s in said if s.rule == "unrelated")


def test_an_input_that_is_but_noise_is_no_fault_of_its_reference():
    runs = [moving(s, movement=s, noise=1e-3) for s in range(6)]
    runs = [replace(r, tension_ref_n=moving(9, movement=s).tension_in_n) for s, r in enumerate(runs)]
    still = np.random.default_rng(1).normal(12.0, 0.025, N)
    assert "reference" in rules([replace(runs[0], tension_in_n=runs[1].tension_in_n), *runs[1:]])
    assert "reference" not in rules([replace(runs[0], tension_in_n=still), *runs[1:]])


@pytest.mark.parametrize("seed", asked(range(4), 0, 3))
def test_an_input_of_another_movement_explains_no_output(seed):
    a, b = moving(seed, movement=seed), moving(9, movement=seed + 20)
    (said,) = gate.remarks([replace(a, tension_in_n=b.tension_in_n)])
    assert said.rule == "unrelated"


@pytest.mark.parametrize("noise", [0.01, 0.05])
def test_a_noisy_sensor_is_none_of_another_recording(noise):
    for seed in range(3):
        assert not {"unrelated", "duplicate"} & set(rules([moving(seed, noise=noise, movement=seed)]))


def test_an_output_beside_another_input_is_told_with_both_runs_and_two_outputs_of_one_input_are_not():
    a, b = moving(1, 0.4, config_id="a"), moving(2, 0.6, config_id="b")
    said = gate.remarks([replace(a, tension_out_n=b.tension_out_n), b])
    assert said[0].rule == "duplicate" and said[0].run_ids == ("r1", "r2") and "output" in said[0].sentence
    # begun somewhat later
    later = replace(a, time_s=a.time_s[:-40], tension_in_n=a.tension_in_n[:-40], tension_out_n=b.tension_out_n[40:])
    assert gate.remarks([later, b])[0].rule == "duplicate"
    assert rules([a, b]) == [] and rules([a, replace(b, tension_in_n=a.tension_in_n)]) == []


def seamless(first, second):
    """Return a run that goes on as another one of the same movement from a sample of the middle half on, at which both outputs read the same."""
    near = np.arange(N // 4, 3 * N // 4)
    k = int(near[np.argmin(np.abs(first.tension_out_n[near] - second.tension_out_n[near]))])
    assert abs(first.tension_out_n[k] - second.tension_out_n[k]) < 0.05
    return k, replace(first, tension_out_n=np.concatenate((first.tension_out_n[:k], second.tension_out_n[k:])))


@pytest.mark.each_once
@pytest.mark.parametrize("movement", asked((0, 1, 3, 4), 0, 3))
@pytest.mark.parametrize("wraps", [(0.4, 0.55), (0.8, 0.6)])
def test_two_bends_joined_where_both_read_the_same_are_told_with_time_and_friction(movement, wraps):
    k, r = seamless(*(moving(i, w, movement=movement) for i, w in enumerate(wraps)))
    (said,) = gate.remarks([r])
    assert said.rule == "joined" and said.number == pytest.approx(wraps[1] / wraps[0], rel=0.05)
    assert gate.evidence_of(r).shapes.parted.at_s == pytest.approx(T[k], abs=3.0)


def test_friction_that_fades_over_a_path_without_end_is_not_asked_for_another_bend():
    k, r = seamless(*(moving(i, w) for i, w in enumerate((0.4, 0.55))))
    causes = gate.evidence_of(r).causes
    points = (r.time_s, r.tension_in_n, r.tension_out_n)
    assert parted_of(points, 0.02, causes.least_n(float(T[-1])), causes).at_s == pytest.approx(T[k], abs=3.0)
    # where the fading law explains more than a size that changes at no sample, and the sample leaves more than noise, the law bends what is read
    fades = replace(causes, noise_n=0.1 * causes.noise_n, fading=replace(causes.friction, rms_n=0.9 * causes.friction.rms_n))
    assert parted_of(points, 0.02, causes.least_n(float(T[-1])), fades) is None
    fits = replace(fades, noise_n=causes.noise_n)
    assert parted_of(points, 0.02, causes.least_n(float(T[-1])), fits) is not None


@pytest.mark.each_once
@pytest.mark.parametrize("movement", asked(range(5), 0, 3))
@pytest.mark.parametrize("over_s", asked((3.0, 10.0, 30.0), 10.0))
def test_friction_that_runs_in_is_no_second_recording(movement, over_s):
    r = moving(0, movement=movement)
    y, v = np.empty(N), r.tension_in_n[0] * np.exp(-0.5)
    for k, (x, w) in enumerate(zip(r.tension_in_n, 0.5 + 0.15 * np.exp(-T / over_s), strict=True)):
        v = min(max(v, x * np.exp(-w)), x * np.exp(w))
        y[k] = v
    assert "joined" not in rules([replace(r, tension_out_n=y)])


@pytest.mark.each_once
@pytest.mark.parametrize("top", [0.5, 25.0, 400.0])
@pytest.mark.parametrize("share", [0.05, -0.05])
@pytest.mark.parametrize("channel", ["tension_in_n", "tension_out_n"])
def test_a_sensor_tared_anew_before_one_run_is_told_at_any_size(top, share, channel):
    runs = [moving(i, 0.4 + 0.05 * i, top, movement=i, zero=0.02 * top, config_id=f"b{i}") for i in range(5)]
    assert rules(runs) == []
    by = share * top
    runs[2] = replace(runs[2], **{channel: getattr(runs[2], channel) + by})
    said = [s for s in gate.remarks(runs) if s.rule == "zero"]
    assert said[0].run_ids == ("r2",)
    if top < 100.0:
        # a large one is below no tension, or beyond any zero by itself
        assert channel in said[0].mend and said[0].number == pytest.approx(by, rel=0.2)


@pytest.mark.each_once
@pytest.mark.parametrize("top", [0.5, 25.0, 400.0])
@pytest.mark.parametrize("zero", [0.0, 0.05])
def test_an_output_tared_anew_midway_is_told_beside_a_zero_that_is_off(top, zero):
    r = moving(3, 0.5, top, zero=zero * top)
    by = 0.05 * np.ptp(r.tension_out_n)
    said = gate.remarks([replace(r, tension_out_n=r.tension_out_n + by * (T >= 21.0))])
    assert said[0].rule == "zero_change" and said[0].number == pytest.approx(by, rel=0.1)


@pytest.mark.parametrize("hold", [3, 7])
def test_a_ramp_through_a_sensor_renewed_now_and_then_has_the_step_of_its_converter(hold):
    t = np.arange(3000) / 100.0
    ramp = 5.0 + 20.0 * np.abs((t / 15.0) % 1.0 - 0.5)
    step = 0.02
    held = (np.round((ramp + 0.004 * np.random.default_rng(1).standard_normal(len(t))) / step) * step)[np.arange(len(t)) // hold * hold]
    s = gate.sensor_of("tension_in_n", t, held)
    assert s.held and s.stride == hold and s.step_n == pytest.approx(step, rel=1e-6)


def steep(stands_still=False):
    """Return a run of a loop whose friction holds the output at its highest for a part of the way, behind coarse levels that are renewed now and then."""
    x = np.interp(T, [0.0, 4.0, 20.0, 20.2, 30.0, 32.0, 40.0], [1.0, 8.0, 0.5, 0.1, 6.0, 8.0, 0.1])
    scatter = 0.004 * np.random.default_rng(1).standard_normal((2, N))
    y = play(x, lines(1.4)) + scatter[1]
    if stands_still:
        y[200:1900] = y[200]
    return Run("steep", "sstl", T, x + scatter[0], (np.round(y / 0.1) * 0.1)[np.arange(N) // 20 * 20])


def test_an_output_held_by_much_friction_behind_coarse_levels_is_not_stuck():
    assert "stuck" in rules([steep(True)])
    e = gate.evidence_of(steep())
    # whatever its repeated values look like
    still = replace(e.sensors[1], still_s=16.0, still_at_s=4.0, still_share=0.4, still_left=True)
    assert "stuck" not in {r.rule for r in gate.judge([replace(e, sensors=(e.sensors[0], still), stuck_while_n=(0.0, 7.0))])}


def test_a_zero_within_what_the_range_of_a_sensor_allows_is_passed_where_friction_leaves_little_of_it():
    def below(zero):
        r = moving(1, 1.6, 90.0)
        return rules([replace(r, tension_out_n=r.tension_out_n + zero - r.tension_out_n.min())])

    assert "zero" not in below(-3.0) and "zero" in below(-6.0)

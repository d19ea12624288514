"""What no sound law of friction is accused of, and the slips beside it that are still told: labels, gains, zeros, delays, positions and joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine
from identification_slips import bend, changed, dahl, exchanged, rig, slow_to_build_up
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification.gate import evidence_of, judge, remarks
from sstl_cli.identification.gate.bounds import flipped_fits, turned
from sstl_cli.identification.gate.causes import NO_CAUSES, Cause
from sstl_cli.identification.gate.clear_gain import clear_gain
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.limits import limit_of
from sstl_cli.identification.gate.movement import loop_work
from sstl_cli.identification.gate.slopes import NO_SLOPES, Slopes


def rules(found):
    return {r.rule for r in found}


def steeper(e: Evidence, factor: float, law: float = 1.0) -> Evidence:
    """Return a run whose lines tell friction ``factor`` times as large, beside laws of friction that tell it ``law`` times as large and leave more than noise."""
    wrap = factor * e.causes.friction.wrap
    told = law * e.causes.friction.wrap
    causes = replace(
        e.causes,
        friction=Cause(told, 0.0, 20.0 * e.causes.noise_n),
        fading=Cause(told, 0.0, 15.0 * e.causes.noise_n),
        **{name: Cause(told, 0.0, 20.0 * e.causes.noise_n) for name in ("gain", "zero_in", "zero_out", "moved", "slow", "speed", "creep")},
    )
    return replace(e, slopes=Slopes(float(np.exp(-wrap)), 0.0, float(np.exp(wrap)), 0.0, 0.001, 0.001), causes=causes)


def test_friction_is_known_to_what_the_laws_that_explain_a_run_tell() -> None:
    # a play leaves no choice, of what builds up over a long path its law is among the answers
    low, high = evidence_of(rig()[2]).wraps
    assert low == pytest.approx(0.4, rel=0.03) and high == pytest.approx(0.4, rel=0.03)
    for r in slow_to_build_up((0.3, 0.5)):
        low, high = evidence_of(r).wraps
        wrap = (0.3 if "b030" in r.run_id else 0.5) * (2 if r.system == "sstl" else 1)
        assert low < 1.05 * wrap and high > 0.95 * wrap


def test_lines_of_presliding_accuse_no_label_that_a_law_allows() -> None:
    log = [evidence_of(r) for r in rig()]

    def said(law: float) -> list[tuple[str, tuple[str, ...]]]:
        return [
            (r.rule, r.run_ids) for r in judge([steeper(e, 2.0, law) if e.run_id == "act-b050" else e for e in log]) if r.rule == "passes"
        ]

    assert said(law=1.0) == []
    # where all laws tell a double pass as well, it is one
    assert said(law=2.0) == [("passes", ("act-b050",))]


def test_lines_of_presliding_shuffle_no_configurations_that_a_law_allows() -> None:
    assert "exchanged" in rules(remarks(exchanged()))
    # the same lines, where laws tell of each loop twice what they tell of its actuation
    by = {"sstl-b020": 3.0, "sstl-b080": 1.0 / 3.0}
    log = [steeper(e, by[e.run_id]) if e.run_id in by else e for e in map(evidence_of, rig())]
    assert "exchanged" not in rules(judge(log))
    assert "exchanged" in rules(judge([steeper(e, by[e.run_id], by[e.run_id]) if e.run_id in by else e for e in map(evidence_of, rig())]))


def test_only_slips_that_explain_about_as_well_as_the_best_speak_for_lines() -> None:
    causes = replace(NO_CAUSES, noise_n=0.01, friction=Cause(0.3, 0.0, 0.5), gain=Cause(0.4, 0.1, 0.1), zero_in=Cause(0.5, 1.0, 0.15))
    assert causes.likely(2.0) == (causes.gain, causes.zero_in)
    assert causes.likely(1.2) == (causes.gain,)
    # of what leaves but noise nothing is worse than another
    assert replace(causes, friction=Cause(0.3, 0.0, 0.019), gain=Cause(0.4, 0.1, 0.01)).likely(1.0)[0].wrap == 0.3


def test_a_gain_is_not_clear_where_friction_that_fades_explains_the_run_as_well() -> None:
    e = evidence_of(replace(rig()[2], tension_out_n=1.3 * rig()[2].tension_out_n))
    assert np.exp(clear_gain(e)) == pytest.approx(1.3, rel=0.02)
    fades = replace(e.causes, fading=Cause(0.4, 0.0, 1.5 * e.causes.noise_n))
    assert np.isnan(clear_gain(replace(e, causes=fades)))


@pytest.mark.parametrize("gain", [1.0, 1.3])
def test_lines_of_a_run_that_friction_alone_explains_accuse_no_gain(gain: float) -> None:
    def repeat(seed: int, by: float = 1.0) -> Run:
        r = bend("b050", 0.4, "act", seed)
        return replace(r, run_id=f"r{seed}", tension_out_n=by * r.tension_out_n)

    log = [evidence_of(r) for r in (repeat(1), repeat(2), repeat(3, gain))]
    if gain == 1.0:
        # its lines are off by what would be told of a gain
        s = log[2].slopes
        log[2] = replace(log[2], slopes=replace(s, gamma_p=1.14 * s.gamma_p, gamma_r=1.14 * s.gamma_r))
    assert [r.run_ids for r in judge(log) if r.rule == "gain"] == ([] if gain == 1.0 else [("r3",)])


def test_one_label_is_told_by_what_passes_on_where_no_lines_show() -> None:
    log = [
        replace(bend("b040", 0.4, system, 10 * n + passes), run_id=f"{system}-{n}")
        for n in (1, 2, 3)
        for passes, system in ((1, "act"), (2, "sstl"))
    ]
    assert remarks(log) == ()
    # as where presliding hides all lines of this bend, and those of others are seen
    hidden = [replace(evidence_of(r), slopes=NO_SLOPES, play=None) for r in log]
    known = [evidence_of(r) for r in rig()]
    assert "passes" not in rules(judge([*known, *hidden]))
    for k, right in ((2, "act"), (3, "sstl")):
        wrong = replace(hidden[k], system="sstl" if right == "act" else "act")
        (said,) = [r for r in judge([*known, *hidden[:k], wrong, *hidden[k + 1 :]]) if r.rule == "passes"]
        assert said.run_ids == (wrong.run_id,) and f'system = "{right}"' in said.mend and not said.failed
        # another range of tension tells nothing of it
        low = replace(wrong, ranges=(replace(wrong.ranges[0], high=1.4 * wrong.ranges[0].high), wrong.ranges[1]))
        assert "passes" not in rules(judge([*known, *hidden[:k], low, *hidden[k + 1 :]]))


def late(r: Run, by_s: float) -> Run:
    return replace(r, tension_out_n=np.interp(r.time_s - by_s, r.time_s, r.tension_out_n))


def test_drag_that_delays_each_pass_is_no_clock() -> None:
    log = [late(r, 0.3 * (2 if r.system == "sstl" else 1)) for r in rig()]
    assert "lead" not in rules(remarks(log))
    assert "lead" in rules(remarks([late(r, 0.45) for r in rig()]))
    # beside it one that is late by far more is
    odd = [late(r, 1.5) if r.run_id == "act-b050" else r for r in log]
    assert ("lead", ("act-b050",)) in [(r.rule, r.run_ids) for r in remarks(odd)]


def test_a_position_that_goes_its_own_way_a_little_more_than_others_is_none_of_another_run() -> None:
    def moved(r: Run, seed: int, creep: float) -> Run:
        slow = np.empty(len(r))
        state = r.tension_in_n[0]
        for k, v in enumerate(r.tension_in_n):
            state += 0.01 * (v - state)
            slow[k] = state
        noise = 0.02 * np.random.default_rng(seed).standard_normal(len(r))
        return replace(r, position_in_mm=0.3 * ((1.0 - creep) * r.tension_in_n + creep * slow) + noise)

    runs = [bend("b050", 0.4, "act", seed, movement=seed) for seed in (1, 2, 3, 4, 5)]
    runs = [replace(r, run_id=f"r{i}") for i, r in enumerate(runs)]
    sound = [moved(r, i, 0.2 + 0.02 * i) for i, r in enumerate(runs)]
    assert "position" not in rules(remarks(sound))
    wrong = [*sound[:4], replace(sound[4], position_in_mm=sound[0].position_in_mm)]
    assert [r.run_ids for r in remarks(wrong) if r.rule == "position"] == [("r4",)]


def test_noise_of_an_output_that_rests_in_its_loops_gives_no_work() -> None:
    t = np.arange(3000) / 100.0
    x = 10.0 + 4.0 * np.sin(2.0 * np.pi * t / 3.0)
    # it creeps in its rest by a hundredth of what it rose by before
    creep = 0.05 * np.sin(2.0 * np.pi * t / 3.0 + 0.5)
    first = t < 1.0
    y = np.where(first, 2.0 + 5.0 * t, 7.0 + creep)
    x = np.where(first, 4.0 + 6.0 * t, x)
    assert loop_work(x, y) < 0.02
    # one that goes its whole way so gives work
    assert loop_work(x, np.where(first, 2.0 + 5.0 * t, 7.0 + 80.0 * creep)) > 0.02


def test_lines_that_are_not_those_of_friction_tell_no_preload() -> None:
    repeats = [replace(bend("b050", 0.4, "act", s), run_id=f"r{s}") for s in (1, 2, 3, 4)]
    loaded = replace(repeats[3], tension_in_n=repeats[3].tension_in_n + 2.0, tension_out_n=repeats[3].tension_out_n + 2.0)
    log = [evidence_of(r) for r in (*repeats[:3], loaded)]
    assert [r.run_ids for r in judge(log) if r.rule == "zero"] == [("r4",)]
    # lines on which phases and play do not agree tell it as well where they leave but noise, as straight ones do
    unsure = replace(log[3], slopes=NO_SLOPES)
    assert "zero" in rules(judge([*log[:3], unsure]))
    # friction that is less under load bends its lines
    bent = replace(unsure, play=replace(unsure.play, rms_n=4.0 * unsure.causes.noise_n))
    assert "zero" not in rules(judge([*log[:3], bent]))


@pytest.mark.parametrize("path", asked([1.0, 2.0, 4.0], 4.0))
def test_presliding_of_any_length_is_sound(path: float) -> None:
    t, x = multisine(13, 3.0, 26.0, seconds=75.0)
    t, x = t[: len(t) // 3], x[::3]
    log = []
    for i, theta in enumerate((0.15, 0.3, 0.5)):
        for passes, system in ((1, "act"), (2, "sstl")):
            noise = 0.02 * np.random.default_rng(10 * i + passes).standard_normal((2, len(t)))
            y = dahl(x, passes * theta, path, 0.0)
            log.append(Run(f"{system}-{i}", system, t, x + noise[0], y + noise[1], config_id=f"b{i}", trajectory="rand"))
    assert remarks(log) == ()


def test_a_percentage_is_among_the_causes_of_a_gain() -> None:
    # of a range of 30 N, of which the output goes to two thirds
    said = [r for r in remarks(changed(lambda r: replace(r, tension_out_n=r.tension_out_n / 0.3))) if r.rule == "gain"]
    assert said and all("the output is in percent of a range of about 30 N" in r.sentence for r in said)
    # what passes 100 is none
    said = [r for r in remarks(changed(lambda r: replace(r, tension_out_n=8.0 * r.tension_out_n))) if r.rule == "gain"]
    assert said and not any("percent of a range" in r.sentence for r in said)


def test_a_zero_that_friction_by_speed_explains_better_is_no_other_sensor() -> None:
    repeats = [replace(bend("b050", 0.4, "act", s, movement=s), run_id=f"r{s}") for s in range(1, 7)]
    off = replace(repeats[5], tension_out_n=repeats[5].tension_out_n + 3.5)
    log = [evidence_of(r) for r in (*repeats[:5], off)]
    zero = ("r6", "zero of the output")
    causes = log[5].causes
    assert causes.zero_out.rms_n < 2.0 * causes.noise_n and causes.zero_out.size == pytest.approx(3.5, abs=0.1)

    def said(log: list[Evidence]) -> list[tuple[str, str]]:
        return [(r.run_ids[0], "zero of the output") for r in judge(log) if r.rule == "odd_run" and "zero of the output" in r.sentence]

    left = replace(
        causes,
        zero_out=replace(causes.zero_out, rms_n=20.0 * causes.noise_n),
        friction=replace(causes.friction, rms_n=40.0 * causes.noise_n),
    )
    lawless = replace(left, speed=Cause(0.4, 0.2, 30.0 * causes.noise_n), fading=Cause(0.4, 0.0, 60.0 * causes.noise_n))
    by_speed = replace(lawless, speed=Cause(0.4, 0.2, 5.0 * causes.noise_n))
    assert zero in said([*log[:5], replace(log[5], causes=lawless)])
    assert said([*log[:5], replace(log[5], causes=by_speed)]) == []


@pytest.mark.parametrize("kept", [0.1, 0.2, 0.3])
def test_an_output_that_creeps_on_while_its_input_is_held_cuts_no_input_off(kept: float) -> None:
    t = np.arange(4000) / 100.0
    # up in 3 s, held for 2 s, down in 3 s, rest
    loop, times = [5.0, 20.0, 20.0, 5.0, 5.0], [0.0, 3.0, 5.0, 8.0, 10.0]
    held = np.interp(t % 10.0, times, loop)
    creeping = 0.5 * np.interp(t % 10.0, times, [5.0, 20.0, 20.0 + 10.0 * kept, 5.0, 5.0])
    noise = 0.01 * np.random.default_rng(3).standard_normal((2, len(t)))
    assert np.isnan(limit_of(t, held + noise[0], creeping + noise[1], (0.01, 0.01)))
    # one that goes on at its speed has an input that does so, too
    passing = 0.5 * np.interp(t % 10.0, [0.0, 4.0, 8.0, 10.0], [5.0, 25.0, 5.0, 5.0])
    cut = np.minimum(np.interp(t % 10.0, [0.0, 4.0, 8.0, 10.0], [5.0, 25.0, 5.0, 5.0]), 20.0)
    assert limit_of(t, cut + noise[0], passing + noise[1], (0.01, 0.01)) == pytest.approx(20.0, abs=0.1)


def strands(x, wrap):
    """Return an output behind a bundle of plays of many lengths, which shows no line."""
    lengths, held, y = wrap * np.exp(np.linspace(0.0, 1.0, 12)), np.zeros(12), np.empty(len(x))
    u = np.log(x)
    for k in range(len(x)):
        held = np.clip(held + (u[k] - u[max(0, k - 1)]) / lengths, -1.0, 1.0)
        y[k] = x[k] * np.exp(-wrap * np.mean(held))
    return y


def behind_strands(labels, systems=("act", "sstl"), seed=7):
    t = np.arange(1600) / 100.0
    x = 1.5 + 12.0 * (1.0 - np.cos(2.0 * np.pi * t / 8.0))
    rng = np.random.default_rng(seed)
    return [
        Run(
            f"{bend}-{system}", system, t, x + 0.02 * rng.standard_normal(len(x)), strands(x, passes * wrap) + 0.02 * rng.standard_normal(len(x)),
            config_id=label if system == "sstl" else bend, trajectory="sine",
        )
        for (bend, label), wrap in zip(labels.items(), (0.3, 0.4), strict=True)
        for system, passes in zip(systems, (1, 2), strict=True)
    ]  # fmt: skip


@pytest.mark.slow
def test_two_bends_whose_loops_show_no_line_are_told_by_their_order():
    assert not {"exchanged", "labels", "passes"} & rules(remarks(behind_strands({"b1": "b1", "b2": "b2"})))
    found = remarks(behind_strands({"b1": "b2", "b2": "b1"}))
    assert found and found[0].rule == "labels" and "rubs more in act sine and the other in sstl sine" in found[0].sentence


def test_an_order_that_no_law_settles_and_systems_exchanged_in_one_bend_accuse_no_configuration():
    shown = {("b1", "act"): (0.3, 0.4), ("b2", "act"): (0.38, 0.5), ("b1", "sstl"): (0.9, 1.1), ("b2", "sstl"): (0.65, 0.7)}
    cells = {(bend, (system, "sine")): v for (bend, system), v in shown.items()}
    assert not turned(cells, 0.1)
    cells["b2", ("act", "sine")] = (0.5, 0.52)
    assert turned(cells, 0.1) and not flipped_fits(cells)
    # two passes of the second bend rub half as much as one: it is its systems that are exchanged
    one_bend = {
        ("b1", ("act", "")): (0.3, 0.32),
        ("b1", ("sstl", "")): (0.65, 0.7),
        ("b2", ("act", "")): (1.05, 1.1),
        ("b2", ("sstl", "")): (0.45, 0.48),
    }
    assert turned(one_bend, 0.1) and flipped_fits(one_bend)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("channel", "factor", "told"),
    [("tension_out_n", 0.1, "in kgf, not N, or in volts"), ("tension_in_n", 0.25, "in volts or at another gain")],
)
def test_a_gain_of_one_run_behind_presliding_is_told_by_the_noise_that_it_scales(channel: str, factor: float, told: str) -> None:
    log = [
        *behind_strands({"b1": "b1", "b2": "b2"}),
        *(replace(r, run_id=f"{r.run_id}-again") for r in behind_strands({"b1": "b1", "b2": "b2"}, seed=8)),
    ]
    assert not remarks(log)
    odd = replace(log[1], **{channel: factor * getattr(log[1], channel)})
    first = remarks([log[0], odd, *log[2:]])[0]
    assert first.rule == "gain" and first.run_ids == (odd.run_id,) and told in first.sentence
    # a channel that was smoothed is as quiet, and reads what it did
    still = replace(log[1], tension_out_n=np.convolve(np.pad(log[1].tension_out_n, 50, mode="edge"), np.full(101, 1.0 / 101.0), "valid"))
    assert "gain" not in rules(remarks([log[0], still, *log[2:]]))

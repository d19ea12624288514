"""Laws of friction as rivals of slips: what builds up over a long path, what changes with speed, and what both channels share."""

from dataclasses import replace

import numpy as np
import pytest
from identification_loops import multisine, play
from identification_slips import dahl, quiet, rig, slow_to_build_up

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.identification.gate.fading import fading_of, scaled_fading_of


def told(runs):
    return [(r.rule, r.run_ids) for r in gate.remarks(runs)]


def lines(wrap):
    return float(np.exp(-wrap)), 0.0, float(np.exp(wrap)), 0.0


def dragged(name, wrap, system, seed, drag=0.4):
    """Return a run whose friction grows with speed: the play of every sample has its own lines."""
    t, x = multisine(seed, 3.0, 26.0, seconds=120.0)
    t, x = t[: len(t) // 3], x[::3]
    speed = np.abs(np.gradient(x, t))
    slope = np.exp(wrap * (1.0 + drag * (1.0 - np.exp(-speed / np.median(speed)))))
    y = np.empty(len(x))
    v = play(x[:1], lines(wrap))[0]
    for k in range(len(x)):
        v = y[k] = min(max(v, x[k] / slope[k]), x[k] * slope[k])
    noise = 0.02 * np.random.default_rng(seed).standard_normal((2, len(t)))
    return Run(f"{system}-{name}", system, t, x + noise[0], y + noise[1], config_id=name, trajectory="rand")


@pytest.mark.parametrize("wrap", [0.2, 0.6, 1.1])
def test_the_friction_of_a_law_that_never_forgets_is_found_and_a_gain_beside_it(wrap):
    _, x = multisine(21, 3.0, 26.0, seconds=40.0)
    y = dahl(x, wrap) + 0.01 * np.random.default_rng(1).standard_normal(len(x))
    found, left = fading_of(x, y)
    assert found == pytest.approx(wrap, rel=0.03) and left < 0.015
    _, gain, left = scaled_fading_of(x, 0.2248 * y)
    assert np.exp(gain) == pytest.approx(0.2248, rel=0.02) and left < 0.005


def test_a_log_that_builds_up_slowly_is_sound():
    assert told(slow_to_build_up()) == []


@pytest.mark.slow
def test_a_unit_behind_presliding_is_named():
    runs = [replace(r, tension_out_n=r.tension_out_n / 4.448222) for r in slow_to_build_up()]
    (said,) = [r for r in gate.remarks(runs) if r.rule == "gain"]
    assert "the output is in lbf" in said.sentence and len(said.run_ids) == len(runs)


@pytest.mark.slow
def test_channels_swapped_behind_presliding_are_told_alone():
    runs = [replace(r, tension_in_n=r.tension_out_n, tension_out_n=r.tension_in_n) for r in slow_to_build_up()]
    assert {rule for rule, _ in told(runs)} == {"swapped"}


@pytest.mark.parametrize("size", [2.0, -1.8])
def test_a_zero_that_moves_under_drag_is_told(size):
    runs = [dragged(f"b{i}", wrap, "act", 31 + i) for i, wrap in enumerate((0.2, 0.4, 0.6))]
    assert told(runs) == []
    later = np.arange(len(runs[1])) >= 0.45 * len(runs[1])
    runs[1] = replace(runs[1], tension_out_n=runs[1].tension_out_n + size * later)
    (said,) = gate.remarks(runs)
    assert said.rule == "zero_change" and said.run_ids == (runs[1].run_id,)
    assert said.number == pytest.approx(size, abs=0.2)


@pytest.mark.slow
def test_a_difference_is_told_by_the_noise_that_it_shares():
    runs = [replace(r, tension_out_n=r.tension_in_n - r.tension_out_n) for r in rig()]
    (said,) = gate.remarks(runs)
    assert said.rule == "mixed" and "difference" in said.sentence
    assert said.number == pytest.approx(100.0, abs=10.0)


def test_what_vibrates_in_the_tendon_is_no_mixture():
    # the drive's own ripple goes through the bend as far as it rubs
    ripple = 0.03 * np.random.default_rng(5).standard_normal(len(rig()[0]))
    passed = {"b020": 0.8, "b050": 0.6, "b080": 0.4}
    runs = [
        replace(r, tension_in_n=r.tension_in_n + ripple, tension_out_n=r.tension_out_n + passed[str(r.config_id)] * ripple) for r in rig()
    ]
    assert "mixed" not in dict(told(runs))


def test_one_run_that_leads_beside_others_in_time_is_told():
    runs = rig()
    late = replace(runs[1], tension_out_n=np.interp(runs[1].time_s + 0.12, runs[1].time_s, runs[1].tension_out_n))
    # creep of a few percent, by which no delay leaves but noise
    creeping = [
        replace(r, tension_out_n=0.97 * r.tension_out_n + 0.03 * quiet(np.cumsum(r.tension_out_n) / np.arange(1, len(r) + 1)))
        for r in [runs[0], late, *runs[2:]]
    ]
    assert ("lead", (runs[1].run_id,)) in told(creeping)


def test_labels_that_went_round_are_told_where_some_bends_show_no_friction():
    order = {"b010": "b050", "b030": "b080", "b050": "b010", "b080": "b030"}
    runs = [replace(r, config_id=order[str(r.config_id)]) if r.system == "act" else r for r in slow_to_build_up()]
    assert [rule for rule, _ in told(runs)] == ["exchanged"]


@pytest.mark.slow
def test_a_tension_that_is_the_position_again_is_a_copy_and_nothing_exchanged():
    rng = np.random.default_rng(3)
    moved = [replace(r, position_in_mm=0.3 * r.tension_in_n + 0.002 * rng.standard_normal(len(r))) for r in rig()]
    said = {x.rule: x.sentence for x in gate.remarks([replace(r, tension_out_n=r.position_in_mm) for r in moved])}
    assert "position" in said["same_channel"] and "columns" not in said

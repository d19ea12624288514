"""Every rule of the physics gate is hit by the slip it was made for, and by no sound recording."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from identification_loops import multisine, play, trapezoid
from identification_slips import CAUSES
from soon import asked

from sstl_cli.core.runs import Run, read_runs
from sstl_cli.identification import gate
from sstl_cli.identification.gate.fingerprints import NO_PRINTS, NO_SKETCH

SAMPLE = Path(__file__).resolve().parents[2] / "data" / "samples" / "log.parquet"


@cache
def sample():
    return tuple(read_runs(SAMPLE))


def loop(theta, system="act", seed=0, sd=0.02, rate=100.0, kind="multisine", **labels):
    """Return a hand-made run: an ideal capstan of the given wrap and sensors with white noise."""
    t, x = multisine(3, seconds=40.0, rate=rate) if kind == "multisine" else trapezoid(rate=rate, cycles=2)
    n = 2 if system == "sstl" else 1
    y = play(x, (np.exp(-n * theta), 0.0, np.exp(n * theta), 0.0))
    rng = np.random.default_rng(seed)
    noisy = [v + sd * rng.standard_normal(len(t)) for v in (x, y)]
    return Run(labels.pop("run_id", f"r{seed}"), system, t, *noisy, **labels)


def leads(thetas, system="act"):
    return [
        loop(th, system, i, kind="trapezoid", config_id=f"c{i}", location="CP", lead_mm=10.0 * i, trajectory="t")
        for i, th in enumerate(thetas)
    ]


def each(change, which=lambda r: True):
    return [change(r) if which(r) else r for r in sample()]


def of_trapezoids(change):
    """Return both systems of one bend, changed: a slip of every run is as well seen in two as in eight."""
    return [change(r) for r in sample() if "trapezoid" in r.run_id and r.config_id == "CP-020"]


def scaled(fx=1.0, fy=None):
    return lambda r: replace(r, tension_in_n=fx * r.tension_in_n, tension_out_n=(fx if fy is None else fy) * r.tension_out_n)


def moved(by):
    """Return a slip: the output's clock is ahead by ``by`` seconds."""
    return lambda r: replace(r, tension_out_n=np.interp(r.time_s + by, r.time_s, r.tension_out_n))


def stuck(r):
    y = r.tension_out_n.copy()
    a, b = len(y) // 4, len(y) * 3 // 4
    y[a:b] = y[a]
    return replace(r, tension_out_n=y)


def crept(r):
    t = r.time_s
    return replace(r, time_s=t * (1.0 + 0.06 * t / t[-1]))


def drifted(r):
    return replace(r, tension_out_n=np.interp(r.time_s * 0.98, r.time_s, r.tension_out_n))


def first(change):
    return each(change, lambda r: r.run_id == sample()[0].run_id)


def relabelled(ids):
    """Exchange the configurations of the runs named."""
    other = {"CP-020": "CP-080", "CP-080": "CP-020"}
    return each(lambda r: replace(r, config_id=other[r.config_id]), lambda r: r.run_id in ids)


def mixed():
    """Two runs exchange their outputs: columns of different recordings."""
    a, b = loop(0.5, run_id="a"), loop(0.5, run_id="b")
    _, x = multisine(11, seconds=40.0, rate=100.0)
    y = play(x, (0.6, 0.0, 1.6, 0.0))
    return [replace(a, tension_out_n=y + 0.02 * np.random.default_rng(5).standard_normal(len(y))), b]


def two_rigs():
    there = [scaled(1.0, 1.2)(loop(0.5 + 0.02 * i, seed=10 + i, sd=0.06, config_id=f"b{i}")) for i in range(4)]
    return [*(loop(0.5 + 0.02 * i, seed=i, config_id=f"a{i}") for i in range(4)), *there]


SLIPS = {
    "counts": lambda: of_trapezoids(
        lambda r: replace(r, tension_in_n=np.round(80 * r.tension_in_n + 512), tension_out_n=np.round(80 * r.tension_out_n + 512))
    ),
    "magnitude": lambda: each(scaled(1000.0)),
    "magnitude (kN)": lambda: each(scaled(0.001)),
    "same_channel": lambda: of_trapezoids(lambda r: replace(r, tension_out_n=r.tension_in_n * 0.5 + 1.0)),
    "switch": lambda: of_trapezoids(switched("tension_out_n", 1.0)),
    "switch (input, in counts)": lambda: each(switched("tension_in_n", 1023.0)),
    "clock_channel": lambda: of_trapezoids(lambda r: replace(r, tension_in_n=np.arange(len(r)) / 100.0)),
    "time_unit": lambda: each(lambda r: replace(r, time_s=1000.0 * r.time_s)),
    "time_unit (divided)": lambda: each(lambda r: replace(r, time_s=r.time_s / 1000.0)),
    "rate": lambda: first(lambda r: replace(r, time_s=2.0 * r.time_s)),
    "sign": lambda: of_trapezoids(scaled(1.0, -1.0)),
    "sign (both)": lambda: each(scaled(-1.0)),
    "sign (zeroed)": lambda: each(lambda r: replace(r, tension_out_n=40.0 - r.tension_out_n)),
    "reference": lambda: each(lambda r: replace(r, tension_ref_n=4.448 * r.tension_in_n)),
    "gain": lambda: each(scaled(1.0 / 4.448, 1.0)),
    "gain (kN)": lambda: each(scaled(1.0, 0.001)),
    "reversed_time": lambda: first(
        lambda r: replace(r, tension_in_n=r.tension_in_n[::-1].copy(), tension_out_n=r.tension_out_n[::-1].copy())
    ),
    "swapped": lambda: of_trapezoids(lambda r: replace(r, tension_in_n=r.tension_out_n, tension_out_n=r.tension_in_n)),
    "lead": lambda: each(moved(0.3)),
    "lead (late)": lambda: each(moved(-0.8)),
    "drift": lambda: each(drifted),
    "drift (period)": lambda: each(crept),
    "zero": lambda: each(lambda r: replace(r, tension_out_n=r.tension_out_n - 6.0)),
    "zero (lines)": lambda: each(lambda r: replace(r, tension_out_n=r.tension_out_n + 9.0)),
    "stuck": lambda: first(stuck),
    "stuck (always)": lambda: first(lambda r: replace(r, tension_out_n=np.full(len(r), 3.0))),
    "unrelated": mixed,
    "passes": lambda: each(lambda r: replace(r, system="act" if r.system == "sstl" else "sstl")),
    "passes (one)": lambda: first(lambda r: replace(r, system="sstl")),
    "passes (alone)": lambda: [loop(wrap, "act", seed, run_id=f"r{seed}", config_id="a") for seed, wrap in ((1, 1.4), (2, 1.45))],
    "labels": lambda: relabelled([r.run_id for r in sample() if r.system == "sstl"]),
    "labels (cell)": lambda: [*sample(), replace(loop(0.68, config_id="CP-020", location="CP", trajectory="minor_loops", run_id="x"))],
    "lead_order": lambda: leads([0.5, 0.45, 0.6, 0.48, 0.57, 0.44, 0.52]),
    "lead_order (two)": lambda: leads([0.44, 0.46, 0.60, 0.50, 0.52, 0.54, 0.56, 0.58, 0.48]),
    "duplicate": lambda: [*sample(), replace(sample()[2], run_id="copy")],
    "duplicate (scaled)": lambda: [*sample(), replace(scaled(0.22)(sample()[2]), run_id="copy")],
    "duplicate (part)": lambda: [*sample(), replace(part(sample()[2], 700, 2100), run_id="copy")],
    "unit_between_runs": lambda: first(scaled(1 / 4.448)),
    "odd_run": lambda: first(lambda r: replace(r, tension_in_n=r.tension_in_n + 0.2 * np.random.default_rng(1).standard_normal(len(r)))),
    "odd_run (kinds)": two_rigs,
    "joined": lambda: [joined(sample()[2], loop(0.5))],
    "joined (noise)": lambda: [joined(sample()[2], None)],
    "noiseless": lambda: each(lambda r: replace(r, tension_in_n=smooth(r.tension_in_n))),
    "unit_between_runs (half)": lambda: each(scaled(1 / 4.448), lambda r: r.config_id == "CP-020"),
    "lead_mm": lambda: first(lambda r: replace(r, lead_mm=10.0 * r.lead_mm)),
    "labels (every file)": lambda: relabelled([r.run_id for r in (sample()[0], sample()[3], sample()[4], sample()[7])]),
    "stuck (dead)": lambda: first(dead),
    "dead": lambda: each(lambda r: replace(r, tension_out_n=noise(len(r))), lambda r: r.system == "sstl"),
    "dead (input)": lambda: first(lambda r: replace(r, tension_in_n=noise(len(r)))),
    "zero (both)": lambda: each(lambda r: replace(r, tension_in_n=r.tension_in_n - 40.0, tension_out_n=r.tension_out_n - 40.0)),
    "position": lambda: each(lambda r: replace(r, position_in_mm=r.tension_in_n / 5000.0)),
    **CAUSES,
}


def noise(n):
    return 0.01 * np.random.default_rng(6).standard_normal(n)


def switched(name, level):
    return lambda r: replace(r, **{name: level * (getattr(r, name) > np.mean(getattr(r, name)))})


def joined(a, b):
    """Return a run whose second half is another recording, or (None) its own in five times the noise."""
    n = len(a) // 2
    noise = 0.1 * np.random.default_rng(2).standard_normal((2, n))
    tail = (a.tension_in_n[n : 2 * n] + noise[0], a.tension_out_n[n : 2 * n] + noise[1])
    if b is not None:
        apart = np.minimum(abs(b.tension_in_n[:-n] - a.tension_in_n[n]), abs(b.tension_out_n[:-n] - a.tension_out_n[n]))
        at = int(np.argmax(apart))
        tail = (b.tension_in_n[at : at + n], b.tension_out_n[at : at + n])
    x, y = (np.concatenate((v[:n], w)) for v, w in zip((a.tension_in_n, a.tension_out_n), tail, strict=True))
    return replace(a, time_s=a.time_s[: len(x)], tension_in_n=x, tension_out_n=y)


def smooth(v):
    k = np.arange(0, len(v), 10)
    return np.interp(np.arange(len(v)), k, np.convolve(v, np.ones(25) / 25, "same")[k])


def dead(r):
    y = r.tension_out_n.copy()
    y[len(y) // 3 :] = 0.0
    return replace(r, tension_out_n=y)


def part(r, a, b):
    return replace(r, time_s=r.time_s[a:b], tension_in_n=r.tension_in_n[a:b], tension_out_n=r.tension_out_n[a:b])


@pytest.mark.parametrize("name", asked(SLIPS, *(n for n in SLIPS if " (" not in n)))
def test_a_slip_is_told_by_its_rule_first(name):
    said = gate.remarks(SLIPS[name]())
    assert said, name
    assert said[0].rule == name.split(" ")[0], [r.line() for r in said]
    for one in said:
        assert one.sentence and one.mend and np.isfinite(one.number) and one.run_ids
        assert one.run_ids[0] in one.sentence


def test_every_rule_has_a_slip():
    assert {r.RULE for r in gate.catalogue()} == {n.split(" ")[0] for n in SLIPS}


def test_sound_recordings_are_passed_over():
    assert gate.remarks(sample()) == ()
    assert gate.remarks(leads([0.44, 0.46, 0.48, 0.50, 0.52, 0.54, 0.56, 0.58, 0.60])) == ()
    assert gate.remarks([loop(0.05)]) == () and gate.remarks([loop(0.68, "sstl", kind="trapezoid")]) == ()
    assert gate.remarks([]) == ()


@pytest.mark.parametrize("sd", [0.0, 0.2])
def test_noise_is_no_slip(sd):
    assert gate.remarks([loop(0.5, sd=sd, config_id="a"), loop(0.5, "sstl", 1, sd=sd, config_id="a")]) == ()


def test_an_output_that_is_no_tension_has_no_unit_to_judge():
    angles = of_trapezoids(lambda r: replace(r, tension_out_n=57.3 * r.tension_out_n - 300.0))
    assert gate.remarks(angles)
    assert gate.remarks([replace(r, unit_out="deg") for r in angles]) == ()


@pytest.mark.slow
def test_two_values_are_no_switch_where_the_sensor_shows_more_or_the_input_rests():
    step = 20.0
    coarse = [replace(r, tension_out_n=step * np.round(r.tension_out_n / step)) for r in sample()]
    assert len(np.unique(coarse[0].tension_out_n)) == 2
    for system in ("act", "sstl"):
        last = max(i for i, r in enumerate(coarse) if r.system == system)
        coarse[last] = sample()[last]
    assert "switch" not in {r.rule for r in gate.remarks(coarse)}
    r = loop(0.5)
    rest = replace(r, tension_in_n=20.0 + 0.01 * np.sin(r.time_s), tension_out_n=5.0 + 0.1 * (r.time_s % 0.2 > 0.1))
    assert "switch" not in {s.rule for s in gate.remarks([rest])}


def test_a_failed_run_is_told_once():
    said = gate.remarks(SLIPS["counts"]())
    assert len(said) == 1 and said[0].failed and len(said[0].run_ids) == 2


def test_samples_that_cannot_be_judged_are_no_crash():
    r = loop(0.5)
    nan = replace(r, tension_in_n=np.where(r.time_s < 1.0, np.nan, r.tension_in_n))
    backward = replace(r, run_id="b", time_s=r.time_s[::-1])
    short = Run("s", "act", r.time_s[:3], r.tension_in_n[:3], r.tension_out_n[:3])
    none = Run("n", "act", r.time_s[:0], r.tension_in_n[:0], r.tension_out_n[:0])
    assert gate.remarks([nan, backward, short, none]) == ()


@pytest.mark.parametrize(("hold", "step"), [(1, 0.0), (18, 0.0), (5, 0.01), (1, 0.1)])
def test_refresh_and_step_are_found(hold, step):
    r = loop(0.5, rate=500.0)
    y = np.repeat(r.tension_out_n[::hold], hold)[: len(r)]
    y = np.round(y / step) * step if step else y
    inside, out = gate.sensors_of(replace(r, tension_out_n=y))
    assert inside.refresh_s == pytest.approx(0.002) and inside.step_n == 0.0 and not inside.held
    assert out.refresh_s == pytest.approx(hold * 0.002, rel=0.02) and out.held == (hold > 1)
    assert out.step_n == pytest.approx(step, rel=0.01)
    assert out.still_share == 0.0
    assert gate.remarks([replace(r, tension_out_n=y)]) == ()


def test_an_uneven_refresh_is_found():
    r = loop(0.5, rate=1000.0)
    at = np.cumsum(np.random.default_rng(0).integers(16, 21, 4000))
    at = np.concatenate(([0], at[at < len(r)]))
    y = r.tension_out_n[at[np.searchsorted(at, np.arange(len(r)), "right") - 1]]
    found = gate.sensor_of("tension_out_n", r.time_s, y)
    assert found.refresh_s == pytest.approx(0.018, rel=0.06) and found.noise_n == pytest.approx(0.02, rel=0.2)


def test_sixty_thousand_samples_take_no_time(measured_anew):
    from time import process_time

    runs = [loop(0.5, seed=i, rate=250.0, run_id=f"r{i}", config_id=f"c{i}") for i in range(6)]
    gate.remarks(runs[:1])
    start = process_time()
    gate.remarks(runs)
    assert sum(map(len, runs)) == 60_000 and process_time() - start < 0.6


class Passes(list):
    """A log that counts how often it is gone through."""

    count = 0

    def __iter__(self):
        self.count += 1
        return super().__iter__()


@pytest.mark.parametrize("name", asked(("sound", "switch", "stuck (always)", "sign", "noiseless", "counts"), "sound", "sign"))
def test_the_work_of_a_rule_does_not_grow_with_the_square_of_the_runs(name):
    few = [gate.evidence_of(r) for r in (SLIPS[name]() if name in SLIPS else sample())]
    # the same few again and again, which are no copies to any rule
    many = [replace(few[i % len(few)], run_id=f"r{i}", prints=NO_PRINTS, output_prints=NO_PRINTS, sketch=NO_SKETCH) for i in range(300)]
    for rule in gate.catalogue():
        log = Passes(many)
        tracemalloc.start()
        try:
            list(rule.look(log))
            most = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert log.count < 40 and most < 6e6, (rule.RULE, log.count, most)


def test_an_output_that_rests_in_backlash_is_no_copy():
    """Without its few stray samples the output is constant, and a constant is no straight line of the input."""
    runs = []
    for seed in range(3):
        r = loop(0.5, seed=seed, sd=0.001, run_id=f"r{seed}")
        y = np.full(len(r), 5.0)
        y[[200 + seed, 900]] = 5.1
        runs.append(replace(r, tension_out_n=y))
    assert gate.remarks(runs) == ()


def test_runs_without_noise_are_no_copies_for_the_rounding_of_their_numbers():
    # straight up and down: rounding is all that second differences of one movement hold, and most of it is alike in both outputs
    t = np.arange(0.0, 30.0, 0.01)
    x = np.interp(t, [0.0, 15.0, 30.0], [1.0, 30.0, 1.0])
    outputs = {th: play(x, (np.exp(-th), 0.0, np.exp(th), 0.0)) for th in (0.49, 0.56)}
    runs = [Run(f"r{th}", "act", t, x, y, config_id=f"c{th}") for th, y in outputs.items()]
    assert not [s for s in gate.remarks(runs) if s.rule == "duplicate"]


def test_a_slow_output_shares_no_noise_with_another_run():
    """Ramps between held values turn at the same beat in every run, whatever the noise."""
    runs = []
    for seed in range(2):
        r = loop(0.4 + 0.1 * seed, seed=seed, rate=500.0, run_id=f"r{seed}", config_id=f"c{seed}")
        at = np.arange(0, len(r), 8)
        y = np.interp(np.arange(len(r)), at, r.tension_out_n[at])
        runs.append(replace(r, tension_out_n=y))
    assert not [s for s in gate.remarks(runs) if s.rule == "duplicate"]


@pytest.mark.parametrize("largest", [0.15, 500.0])
def test_small_and_large_rigs_are_sound(largest):
    runs = [loop(0.5 * n, system, n, config_id="a", run_id=system) for n, system in ((1, "act"), (2, "sstl"))]
    f = largest / max(float(r.tension_in_n.max()) for r in runs)
    assert gate.remarks([scaled(f)(r) for r in runs]) == ()


def passes_of(runs):
    return [r.run_ids for r in gate.remarks(runs) if r.rule == "passes"]


def test_a_loop_that_swallows_the_motion_says_that_the_other_run_is_a_single_pass():
    bend = {"config_id": "a", "location": "CP"}
    single = loop(1.4, "act", 1, run_id="single", **bend)
    double = loop(1.4, "sstl", 2, run_id="double", **bend)
    # a movement within the backlash: the output rests and shows no slopes
    x = double.tension_in_n
    rests = double.tension_out_n.mean() + 0.02 * np.random.default_rng(6).standard_normal(len(x))
    double = replace(double, tension_in_n=x.mean() + 0.3 * (x - x.mean()), tension_out_n=rests)
    assert not gate.evidence_of(double).slopes.known
    assert passes_of([single]) == [("single",)]
    assert passes_of([single, double]) == []
    # on another bend it says nothing
    assert passes_of([single, replace(double, config_id="b")]) == [("single",)]


def test_a_small_movement_says_nothing_of_the_size_of_friction():
    wide = loop(0.4, "sstl", 3, run_id="wide")
    t, x = wide.time_s, wide.tension_in_n
    # presliding: many plays side by side have no line in common
    spread = [play(x, (np.exp(-a), 0.0, np.exp(a), 0.0)) for a in np.linspace(0.0, 1.6, 9)]
    wide = replace(wide, tension_out_n=np.mean(spread, axis=0) + 0.02 * np.random.default_rng(5).standard_normal(len(t)))
    assert not gate.evidence_of(wide).slopes.known
    small = loop(0.1, "sstl", 4, run_id="small", sd=0.002)
    small = replace(small, tension_in_n=0.1 * small.tension_in_n, tension_out_n=0.1 * small.tension_out_n)
    assert passes_of([small]) == [("small",)]
    assert passes_of([small, wide]) == []


@pytest.mark.parametrize("label", ["act", "sstl"])
def test_both_systems_under_one_label(label):
    runs = [
        replace(loop(th, system, 10 * i + 2 * k + len(system), run_id=f"{name}-{system}-{k}", config_id=name, trajectory="t"), system=label)
        for i, (name, th) in enumerate({"a": 0.35, "b": 0.45}.items())
        for system in ("act", "sstl")
        for k in range(2 if system == label else 1)
    ]
    (told,) = [r for r in gate.remarks(runs) if r.rule == "passes"]
    other = {"act": "sstl", "sstl": "act"}[label]
    assert told.failed and told.run_ids == (f"a-{other}-0", f"b-{other}-0")
    assert told.mend.startswith(f'[constants] system = "{other}"')
    # on a single bend a file of another bend may look like that
    (doubt,) = [r for r in gate.remarks([r for r in runs if r.config_id == "a"]) if r.rule == "passes"]
    assert not doubt.failed and doubt.run_ids == (f"a-{other}-0",)

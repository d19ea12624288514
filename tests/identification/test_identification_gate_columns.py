"""Columns taken twice, a position that counts the wrong way, harmonics that are no hum, and mends that mend."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from identification_loops import play
from identification_slips import lines
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.identification import gate
from sstl_cli.importers.mapping import mapping_of
from sstl_cli.steps import import_


def loop(seed, top=24.0, rate=100.0, seconds=40.0, wrap=0.4, system="act", shape="waves", noise=5e-4):
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    w = sum(rng.normal() * np.sin(2.0 * np.pi * f * t + rng.uniform(0.0, 6.28)) for f in rng.uniform(0.05, 0.5, 9))
    w = (w - w.min()) / np.ptp(w) if shape == "waves" else 2.0 * np.abs((shape * t) % 1.0 - 0.5)
    command = top * (0.1 + 0.9 * w)
    x = np.convolve(np.pad(command, (4, 0), mode="edge"), np.full(5, 0.2), "valid")
    y = play(x, lines(wrap * (2 if system == "sstl" else 1)))
    noises = top * noise * rng.standard_normal((3, len(t)))
    position = (0.7 * x + 0.3 * y) / (0.4 * top) + noises[2] / top
    return Run(
        f"{system}{seed}", system, t, x + noises[0], y + noises[1], config_id=f"b{seed}", position_in_mm=position, tension_ref_n=command
    )


def rig(**more):
    return [loop(seed, wrap=0.2 + 0.15 * seed, **more) for seed in range(4)]


def each(change, runs):
    return [change(r) for r in runs]


@pytest.mark.each_once
@pytest.mark.parametrize("top", asked((3.0, 24.0, 120.0), 24.0))
@pytest.mark.parametrize(
    ("a", "b"), [("tension_in_n", "tension_ref_n"), ("tension_ref_n", "tension_out_n"), ("position_in_mm", "tension_in_n"), ("position_in_mm", "tension_ref_n")]
)  # fmt: skip
def test_two_columns_of_the_same_numbers_are_told_and_no_others(top, a, b):
    assert gate.remarks(rig(top=top)) == ()
    said = gate.remarks(each(lambda r: replace(r, **{a: getattr(r, b).copy()}), rig(top=top)))
    (copy,) = [r for r in said if r.rule == "same_channel"]
    assert a in copy.mend and b in copy.mend and len(copy.run_ids) == 4
    # a reference that holds the input, or the position, leaves the tensions as they are
    spoils = (a, b) not in (("tension_in_n", "tension_ref_n"), ("position_in_mm", "tension_ref_n"))
    assert copy.failed == spoils and (not spoils or said == (copy,))


@pytest.mark.slow
@pytest.mark.parametrize("noise", [5e-4, 5e-3])
def test_two_sensors_of_one_tension_lose_nothing_at_any_bend(noise):
    rng = np.random.default_rng(3)

    def beside(r):
        return replace(r, tension_out_n=0.95 * r.tension_in_n + 0.3 + 24.0 * noise * rng.standard_normal(len(r)))

    log = rig(noise=noise)
    (said,) = [r for r in gate.remarks(each(beside, log)) if r.rule == "same_channel"]
    assert len(said.run_ids) == 4 and not said.failed and "nothing is lost to friction" in said.sentence
    # one straight tube may be like that, and where one bend loses something the others may be straight
    for few in ([beside(log[0])], [*map(beside, log[:3]), log[3]]):
        assert "same_channel" not in {r.rule for r in gate.remarks(few)}


@pytest.mark.parametrize("top", [3.0, 24.0, 120.0])
def test_a_position_that_falls_as_the_tension_rises_counts_the_wrong_way(top):
    turned = each(lambda r: replace(r, position_in_mm=-r.position_in_mm), rig(top=top))
    (said,) = gate.remarks(turned)
    assert said.rule == "position" and "sign = -1" in said.mend and len(said.run_ids) == 4


@pytest.mark.parametrize(("size", "line"), [(-1.0, "sign = -1"), (1 / 25.4, 'unit = "in"'), (0.1, 'unit = "cm"'), (1e-3, 'unit = "m"'), (1e3, 'unit = "um"')])  # fmt: skip
def test_a_position_of_one_run_that_is_another_than_that_of_the_others_is_told(size, line):
    runs = rig()
    (said,) = gate.remarks([*runs[:2], replace(runs[2], position_in_mm=size * runs[2].position_in_mm), runs[3]])
    assert said.rule == "position" and said.run_ids == (runs[2].run_id,) and not said.failed
    assert line in said.mend


def test_where_two_units_of_a_position_are_as_likely_both_are_named():
    # where bends differ by as much as that, it may be either
    runs = [*rig(), loop(4, wrap=0.4), loop(5, wrap=0.5)]
    runs = [replace(r, position_in_mm=s * r.position_in_mm) for r, s in zip(runs, (1.0, 1.0, 1 / 16.5, 1.0, 1.55, 1.0), strict=True)]
    (said,) = gate.remarks(runs)
    assert said.run_ids == (runs[2].run_id,) and 'unit = "in"' in said.mend and 'unit = "cm"' in said.mend


def test_a_softer_rig_beside_others_has_no_other_unit():
    runs = rig()
    for softer in (1.5, 5.0):
        assert gate.remarks([*runs[:3], replace(runs[3], position_in_mm=softer * runs[3].position_in_mm)]) == ()
    # of two halves neither is the others
    halves = [replace(r, position_in_mm=s * r.position_in_mm) for r, s in zip(runs, (1.0, 1.0, -1.0, -1.0), strict=True)]
    assert gate.remarks(halves) == ()


@pytest.mark.each_once
@pytest.mark.parametrize("shape", [0.4, 1.0, 2.0, 3.7])
@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_a_harmonic_of_the_movement_is_no_hum_where_the_output_does_not_follow(shape, rate):
    runs = [replace(loop(i, top=14.0, shape=shape, rate=rate, seconds=20.0, wrap=w), config_id=None) for i, w in enumerate((0.6, 1.6))]
    assert not {r.rule for r in gate.remarks(runs)} & {"hum"}


@pytest.mark.parametrize("shape", [0.4, 1.0])
def test_hum_beside_such_a_movement_is_hum(shape):
    runs = [loop(i, shape=shape, rate=250.0, seconds=20.0, wrap=0.4 + 0.8 * i) for i in range(2)]
    spoilt = each(
        lambda r: replace(r, tension_out_n=r.tension_out_n + 0.05 * np.ptp(r.tension_out_n) * np.sin(2 * np.pi * 50.03 * r.time_s)), runs
    )
    assert "hum" in {r.rule for r in gate.remarks(spoilt)}


def test_rows_out_of_order_have_no_unit_of_time():
    for seed in range(6):
        at = np.random.default_rng(seed).permutation(4000)
        runs = each(
            lambda r, at=at: replace(r, time_s=r.time_s[at], tension_in_n=r.tension_in_n[at], tension_out_n=r.tension_out_n[at]), rig()
        )
        assert "time_unit" not in {r.rule for r in gate.remarks(runs)}


def spoilt(name, runs):
    """Return runs with one slip that a line of the mapping undoes."""
    kind, channel, size = name
    if kind == "time":
        return each(lambda r: replace(r, time_s=size * r.time_s), runs)
    hit = runs[2:3] if kind == "one" else runs
    new = [replace(r, **{c: size * getattr(r, c) for c in channel.split()}) for r in hit]
    return [next((n for n in new if n.run_id == r.run_id), r) for r in runs]


SPOILT = [
    ("all", "tension_out_n", 0.25), ("all", "tension_out_n", 0.11), ("all", "tension_in_n", 0.35), ("all", "tension_out_n", 3.1), ("all", "tension_out_n", 2.0),
    ("all", "tension_in_n", 2.0), ("all", "tension_out_n", 1.0 / 4.448222), ("all", "tension_in_n", 1.0 / 9.80665), ("all", "tension_out_n", -1.0),
    ("all", "tension_in_n tension_out_n", 1e-3), ("all", "tension_in_n tension_out_n", 1e3), ("all", "position_in_mm", -1.0), ("one", "tension_out_n", 2.0),
    ("one", "position_in_mm", -1.0), ("one", "position_in_mm", 1.0 / 25.4), ("one", "position_in_mm", 0.1),
    ("one", "tension_in_n", 2.0), ("one", "tension_out_n", 0.4), ("one", "tension_in_n tension_out_n", 1.0 / 4.448222), ("time", "time_s", 1e3),
]  # fmt: skip


@pytest.mark.parametrize("name", asked(SPOILT, *(SPOILT[i] for i in (0, 2, 8, 10, 12, 14))))
def test_a_line_that_mends_makes_the_recording_sound(name, tmp_path):
    runs = spoilt(name, [replace(r, tension_ref_n=None) for r in rig()])
    said = gate.remarks(runs)
    assert said, name
    # of alternatives either is sound
    for choice in said[0].mend.split(" (for this file")[0].split(" or "):
        mended = [imported(r, choice if r.run_id in said[0].run_ids else "", tmp_path) for r in runs]
        # the line does not tell the rig's own size: a tension of another size is a tension
        left = [r for r in gate.remarks(mended) if r.rule not in ("magnitude", "unit_between_runs", "odd_run")]
        assert left == [], (choice, [r.line() for r in left])


def imported(r, mend, folder):
    """Return a run as the import makes it of a text file, with the lines of a mend in the mapping."""
    columns = {"time_s": ("t", "s"), "tension_in_n": ("a", "N"), "tension_out_n": ("b", "N"), "position_in_mm": ("p", "mm")}
    numbers = np.column_stack([getattr(r, c) for c in columns])
    path = folder / f"{r.run_id}.csv"
    np.savetxt(path, numbers, fmt="%.9g", delimiter=",", header="t,a,b,p", comments="")
    document = {
        "format": "text",
        "columns": {c: {"column": n, "unit": u} for c, (n, u) in columns.items()},
        "constants": {"system": r.system, "run_id": r.run_id},
    }
    for line in filter(None, mend.split("; ")):
        name, said = line.split(" = ", 1)
        source = tomllib.loads(f"x = {said.replace('...', repr(columns[name][0]))}")["x"]
        document["columns"][name] = {**({} if "unit" in source else {"unit": columns[name][1]}), **source}
    (run,) = import_.run([path], mapping_of(document, "test")).runs
    return replace(run, run_id=r.run_id, config_id=r.config_id)

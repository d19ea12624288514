"""Each test of a residual on a handful of samples, its statistic by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_fits import NOISE_N, made, noise, simulator
from made_sims import sim

from sstl_cli.diagnosis import residuals
from sstl_cli.diagnosis.constants import FEW
from sstl_cli.diagnosis.residuals import LINE, SINGLE, Leftover, Misfit, leftover


def small(z, keep=None, **more):
    """Return a simulator of one record of these samples, 0.1 s apart, with what ``leftover`` reads of it."""
    made_sim = sim((np.zeros(len(z)), {}))
    made_sim.dispersion, made_sim.edges = more, np.array([0, len(z)])
    made_sim.problem.records[0].time_s = 10.0 + 0.1 * np.arange(len(z))
    return made_sim, np.asarray(z, float), np.ones(len(z), bool) if keep is None else np.asarray(keep)


def test_means_and_spreads_of_bins_by_hand():
    count = FEW + 1
    z = np.concatenate((np.full(count, 1.0), np.full(count, -2.0), [9.0, 9.0]))
    index = np.repeat([0, 1, 2], [count, count, 2])
    mean, spread = residuals._binned("x", z, z, np.ones(len(z), bool), index, ["a", "b", "c"], {}, False)
    # squared sums over counts, and the third bin is too small: 6 + 24 over two bins
    assert mean == Misfit("mean by x", pytest.approx((30.0 - 2.0) / 2.0), pytest.approx(14.0), "b", pytest.approx(15.0))
    # z^2 - 1 is 0 and 3, of variance 2
    assert spread == Misfit("spread by x", pytest.approx((27.0 - 2.0) / 2.0), pytest.approx(12.5), "b", pytest.approx(13.5))
    masked = residuals._binned("x", z, z, index != 1, index, ["a", "b", "c"], {}, False)
    assert masked[0].peak == "a" and masked[0].dispersion == pytest.approx(6.0)


def test_what_is_known_to_exceed_chance_is_taken_off_and_known_no_better_than_its_size():
    plain, usual = residuals._tested("x", 50.0, 8, "p", {}), residuals._tested("x", 50.0, 8, "p", {"x": 4.0, "y": 9.0})
    assert (plain.z, plain.nats, plain.dispersion) == (pytest.approx(42.0 / 4.0), 21.0, 6.25)
    assert (usual.z, usual.nats, usual.dispersion) == (pytest.approx(4.5 / np.sqrt(16.0 + 64.0 * 0.75)), 2.25, 6.25)
    # to leave less than chance once says nothing
    assert residuals._tested("x", 50.0, 8, "p", {"x": 0.1}) == plain


def test_power_over_bands_of_frequency_is_that_of_the_spectrum():
    rng = np.random.default_rng(1)
    z = rng.standard_normal(200)
    keep = np.arange(200) % 7 > 0
    found = residuals._spectrum(*small(z, keep), False)
    n, t = 200, np.arange(200)
    power, count = np.zeros(5), np.zeros(5)
    for k in range(1, 101):
        f = k / 20.0
        band = sum(f > edge for edge in (0.1, 0.5, 2.0, 8.0))
        density = abs(np.sum(z * keep * np.exp(-2j * np.pi * k * t / n))) ** 2 / keep.sum()
        power[band] += density
        count[band] += 1
    used = count > 0
    chi2 = np.sum((power[used] - count[used]) ** 2 / count[used])
    assert (found.name, found.dispersion) == ("power by frequency", pytest.approx(chi2 / used.sum())) and used.sum() == 4
    tone = residuals._spectrum(*small(5.0 * np.sin(2.0 * np.pi * 1.0 * 0.1 * t)), False)
    assert tone.peak == "0.5-2 Hz"


def test_the_highest_line_and_the_largest_sample_are_held_against_chance():
    z = np.zeros(200)
    z[33] = -4.0
    line, single = residuals._lines(*small(z))
    assert single.name == SINGLE and single.z == single.nats == pytest.approx(8.0 - np.log(200.0)) and single.peak == "13.3 s of run r0"
    assert single.dispersion == pytest.approx(8.0 / np.log(200.0))
    # one sample has a flat spectrum of the window's square at it over the window's power
    window = np.hanning(200)
    assert line.name == LINE and line.z == pytest.approx(16.0 * window[33] ** 2 / np.sum(window**2) - np.log(100.0))
    assert line.dispersion == pytest.approx(16.0 * window[33] ** 2 / np.sum(window**2) / np.log(100.0))
    tone = residuals._lines(*small(np.sin(2.0 * np.pi * 2.0 * 0.1 * np.arange(200))))[0]
    assert tone.peak == "2 Hz in run r0"
    usual = residuals._lines(*small(z, None, **{SINGLE: 2.0, LINE: 2.0}))
    assert usual[1].z == pytest.approx(4.0 - np.log(200.0)) and usual[0].z == pytest.approx(0.5 * (line.z + np.log(100.0)) - np.log(100.0))
    masked = residuals._lines(*small(z, np.arange(200) != 33))
    assert masked[1].z == pytest.approx(-np.log(199.0)) and masked[0].peak == ""


def test_every_sample_has_its_bin_of_each_partition():
    u = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 5.0, 3.0, 1.0, 0.0])
    two = sim((u, {"config": 1, "dt_s": 0.125}), (u[::-1], {"dt_s": 0.125, "system": "sstl", "config": 0}), configs=("a", "b"))
    code = np.tile([1] * 8 + [3] * 4, 2)
    bins = residuals._partitions(two, code)
    names = residuals._names(two)
    said = {k: [names[k][i] for i in bins[k]] for k in bins}
    quarters = [said["phase and tension"][i].split(", ")[1] for i in (0, 3, 4, 7)]
    assert [q[8] for q in quarters] == ["1", "2", "3", "4"] and said["phase and tension"][0].startswith("act PP")
    assert said["phase and tension"][-1].startswith("sstl RP")
    # an eighth of a second a sample
    assert said["phase and time since reversal"][:5] == [
        f"act PP, {e} s after a reversal" for e in ("0-0.1", "0.1-0.3", "0.1-0.3", "0.3-1", "0.3-1")
    ]
    assert said["run"][11:13] == ["run r0", "run r1"]
    assert [said["run and time in the run"][i] for i in (0, 2, 3, 11, 12)] == [
        f"run {r}, quarter {q} of 4" for r, q in (("r0", 1), ("r0", 1), ("r0", 2), ("r0", 4), ("r1", 1))
    ]
    assert [said["configuration and phase"][i] for i in (0, 8, 12, 20)] == ["b, act PP", "b, act RP", "a, sstl PP", "a, sstl RP"]
    # the fastest quarter moves by more than the rest
    assert {s[-1:] for s in (x.split("quarter ")[1][:1] for x in said["phase and speed"])} <= set("1234")


def test_moments_of_what_is_left_by_hand():
    fit, model = made(), simulator()
    z = noise(7) / NOISE_N
    found = leftover(model, made(noise(7)))
    assert found.samples == 8000 and found.chi2 == pytest.approx(np.mean(z**2))
    assert found.lag_one == pytest.approx(np.sum(z[1:] * z[:-1]) / 8000 / np.mean(z**2))
    assert found.kurtosis == pytest.approx(np.mean(z**4) / np.mean(z**2) ** 2 - 3.0)
    code = residuals.phases(model, fit.prediction)
    along = np.concatenate((z[code == 1], -z[code == 3]))
    assert found.skewness == pytest.approx(np.mean(along**3) / np.mean(along**2) ** 1.5)
    assert len(found.tests) == 15 and found.worst().z == max(t.z for t in found.tests)
    assert Leftover(1, 5.0, 0.0, 0.0, 0.0, ()).excess == 2.0


def test_less_than_the_known_scatter_is_brought_to_it_and_more_is_not():
    known = replace(
        simulator(),
        problem=replace(simulator().problem, records=tuple(replace(r, misfit_n=np.ones(len(r))) for r in simulator().problem.records)),
    )
    assert leftover(known, made(0.3 * noise(8))).chi2 == pytest.approx(1.0)
    more = leftover(known, made(2.0 * noise(8)))
    assert more.chi2 == pytest.approx(4.0, rel=0.05) and leftover(simulator(), made(0.3 * noise(8))).chi2 == pytest.approx(0.09, rel=0.05)
    # spreads are compared with what is left, a mean with what was known: to leave less makes none of them larger
    quiet = 0.3 * noise(8) + 0.1 * NOISE_N * (simulator().run == 1)
    a, b = ({t.name: t.z for t in leftover(s, made(quiet)).tests} for s in (known, simulator()))
    assert a["mean by run"] == b["mean by run"] and a["spread by run"] < 10.0 < 30.0 < b["spread by run"]


def test_less_noise_than_it_is_at_most_is_no_sign_of_anything():
    model = simulator()
    # a quarter of the runs is as loud as stated, the rest much quieter
    loud = noise(9) * np.where(model.run == 0, 1.0, 0.05)
    plain, bounded = ({t.name: t.z for t in leftover(model, made(loud), at_most).tests} for at_most in (False, True))
    quiet = [n for n in plain if n.startswith("spread") or n == "power by frequency"]
    assert all(plain[n] > 20.0 and bounded[n] < 3.0 for n in quiet)
    assert all(plain[n] == bounded[n] for n in plain if n not in quiet)
    # more of it is one as before
    more = {t.name: t.z for t in leftover(model, made(noise(9) * np.where(model.run == 0, 1.5, 0.05)), True).tests}
    assert more["spread by run"] > 20.0


def test_a_band_of_one_frequency_counts_like_any_other():
    # 100 samples 0.1 s apart: of the multiples of 0.1 Hz one is in the lowest band
    z = 3.0 * np.sin(2.0 * np.pi * np.arange(100) / 100.0)
    found = residuals._spectrum(*small(z), False)
    # all of the power is in that line: 100 * 9 / 4 over 1 expected; the others have none of theirs
    lines = np.array([1, 4, 15, 30])
    expected = (225.0 - 1.0) ** 2 + float(np.sum(lines[1:]))
    assert found.peak == "0-0.1 Hz" and found.dispersion == pytest.approx(expected / 4.0)
    at_most = residuals._spectrum(*small(z), True)
    assert at_most.dispersion == pytest.approx((225.0 - 1.0) ** 2 / 4.0)


def test_a_test_of_which_nothing_is_known_is_dispersed_as_chance_is():
    assert Misfit("x", 0.0, 0.0, "").dispersion == 1.0


def test_quarters_are_told_by_quartiles():
    assert residuals._quartile(np.array([3.0, 0.0, 8.0, 5.0, 1.0])).tolist() == [1, 0, 3, 2, 0]


def test_nothing_kept_says_nothing():
    none = np.zeros(40, bool)
    tests = [*residuals._lines(*small(np.ones(40), none)), residuals._spectrum(*small(np.ones(40), none), False)]
    assert all(np.isfinite([t.z, t.nats, t.dispersion]).all() for t in tests)
    # chance alone makes the larger of two samples, and of two lines, ln 2
    assert tests[1].z == pytest.approx(-np.log(2.0)) and tests[0].z == pytest.approx(-np.log(20.0))
    short = residuals._lines(*small(np.zeros(3)))
    assert short[0].z == pytest.approx(-np.log(2.0)) and short[1].z == pytest.approx(-np.log(3.0))

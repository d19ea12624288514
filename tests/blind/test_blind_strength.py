"""Drawing cases: re-tuning, scaling, schedule and benches against independent calculations."""

from collections import Counter

import numpy as np
import pytest

from sstl_cli.blind.bench import draw as draw_bench
from sstl_cli.blind.cases import draw
from sstl_cli.blind.record import Source
from sstl_cli.blind.retune import Pair, gap_n, retune
from sstl_cli.blind.schedule import Entry, schedule
from sstl_cli.blind.strength import band, direction, find_scale
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.rig import parameters


def backlash(u, theta, passes):
    """Play operator in plain Python: the slowest possible, and nobody else's code."""
    y, out = u[0], []
    for x in u:
        y = min(max(y, np.exp(-passes * theta) * x), np.exp(passes * theta) * x)
        out.append(y)
    return np.array(out)


def test_retune_finds_theta_of_each_configuration():
    u = 10 - 8 * np.cos(np.linspace(0, 12, 1500))
    pairs = [Pair(c, n, u, backlash(u, t, n)) for c, t in enumerate((0.37, 0.61)) for n in (1, 2)]
    assert retune(pairs, [0.5, 0.5]) == pytest.approx([0.37, 0.61], abs=1e-4)
    assert gap_n(pairs, [0.5, 0.5])[0] < 1e-3


def test_retune_keeps_what_no_theta_can_follow():
    u = 10 - 8 * np.cos(np.linspace(0, 12, 1500))
    pairs = [Pair(0, 1, u, backlash(u, 0.4, 1) + 0.3 * np.sin(np.linspace(0, 300, 1500)))]
    assert 0.15 < gap_n(pairs, [0.4])[0] < 0.25


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
def test_scale_search_hits_its_target(power):
    scale, gap = find_scale(lambda s: 3.0 * s**power, 0.3)
    assert gap == pytest.approx(0.3, rel=0.1)
    assert 3.0 * scale**power == pytest.approx(gap)


def test_scale_search_stops_at_the_bound():
    assert find_scale(lambda s: 0.01 * s, 1.0)[0] == 1.0


@pytest.mark.parametrize(("strength", "expected"), [(0.05, None), (0.4, 0.4), (0.61, 1.2), (2.0, 4.0), (40.0, 4.0)])
def test_bands(strength, expected):
    assert band(strength) == expected


@pytest.mark.parametrize("effect_id", list(catalogue()))
def test_directions_stay_inside_the_rig(effect_id):
    for seed in range(5):
        way = direction(effect_id, np.random.default_rng(seed), 30.0, 20.0)
        for scale in (1e-4, 0.3, 1.0):
            for name, value in way.at(scale).items():
                bounds = parameters()[effect_id][name]
                assert bounds.low <= value <= bounds.high
        assert get(effect_id).active({**get(effect_id).neutral(), **way.at(0.5)})


def test_schedule_covers_every_effect_at_every_strength():
    entries = schedule(6 * 78, 5)
    singles = Counter((e.effects[0], e.strength) for e in entries if e.kind == "single")
    alone = {e for e in catalogue() if get(e).channel != "neighbour"}
    assert {e for e, _ in singles} == alone
    assert len(singles) == 3 * len(alone)
    assert {e.kind for e in schedule(24, 1)} == {"single", "none", "pair", "excluded", "unlisted", "nominal", "poor"}
    assert schedule(40, 3) == schedule(40, 3) != schedule(40, 4)
    assert len(schedule(1, 0)) == 1


def test_nothing_withheld_leaves_no_gap():
    source = Source(draw_bench(np.random.default_rng(2), quick=True), 1)
    assert source.gap({})[0] < 0.1 * source.noise_n + 2e-3


@pytest.mark.parametrize("effect_id", ["const_friction", "zero_offset", "quantisation"])
def test_a_case_has_the_strength_it_says(effect_id):
    case = draw(Entry("single", (effect_id,), 4.0), 31, quick=True)
    t = case.truth
    assert t.strength == pytest.approx(4.0, rel=0.15)
    # against the recordings themselves: error of the play operator beyond the noise
    error2 = noise2 = n = 0.0
    ids = sorted({r.config_id for r in case.runs})
    for r in case.runs:
        theta = t.theta_retuned[ids.index(r.config_id)]
        base = backlash(r.tension_in_n, theta, r.passes)
        late = slice(200, None)
        error2 += float(np.sum((r.tension_out_n - base)[late] ** 2))
        n += len(r.tension_out_n[late])
    noise2 = t.noise_n**2
    assert np.sqrt(error2 / n) / np.sqrt(noise2) == pytest.approx(np.hypot(4.0, 1.0), rel=0.35)


def test_both_parts_of_a_pair_show():
    case = draw(Entry("pair", ("const_friction", "channel_delay"), 4.0), 8, quick=True)
    assert len(case.truth.effects) == 2
    assert min(case.truth.shares.values()) >= 1 / 3


def test_cases_are_the_same_again():
    a, b = (draw(Entry("single", ("viscous",), 1.2), 77, quick=True) for _ in range(2))
    assert a.truth == b.truth and a.exclude == b.exclude
    for x, y in zip(a.runs, b.runs, strict=True):
        np.testing.assert_array_equal(x.tension_out_n, y.tension_out_n)


def test_excluding_tells_nothing():
    cases = [draw(Entry("none"), 500 + k, quick=True) for k in range(8)]
    assert 1 <= sum(bool(c.exclude) for c in cases) <= 7
    excluded = draw(Entry("excluded", ("viscous",), 4.0), 9, quick=True)
    assert excluded.exclude == ("viscous",)
    assert all(len(c.exclude) <= 1 for c in cases)

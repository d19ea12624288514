"""Sizes from which a plan tells effects apart, by distances that are known beforehand."""

from __future__ import annotations

from math import exp, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import planning
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.found import NOTHING
from sstl_cli.diagnosis.limit import Shown
from sstl_cli.diagnosis.planning import Planned, Told, classes
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario


def free(name="p", low=0.0, neutral=0.0, high=100.0, shape=False):
    return SimpleNamespace(parameter=SimpleNamespace(name=name, low=low, neutral=neutral, high=high, shape=shape))


def told(monkeypatch, distances, size=1.0, left=1.0, most=1e9):
    """Return what is told by distances that are functions of the size, by rival, and the sizes that were tried."""
    tried = []
    own = SimpleNamespace(free=[free(high=most)], hypothesis=SimpleNamespace(foretold=True))
    found = SimpleNamespace(sim=None, singles={"own": [SimpleNamespace(fit=own)]})
    monkeypatch.setattr(planning, "_sized", lambda sim, fit, name, size: tried.append(size) or size)
    monkeypatch.setattr(planning, "distance2", lambda sim, truth, rival: distances[rival](truth))
    return planning._told(found, Shown("own", "p", "N", size, 0.1), {r: r for r in distances}, left), tried


def test_a_size_is_corrected_by_the_distance_that_grows_with_its_square(monkeypatch):
    # what is left says 1 / 0.6, where the nearest is at 6 (5/3)^2 = 16.7: 24 are reached at 2
    found, tried = told(monkeypatch, {"far": lambda s: 9.0 * s * s, "near": lambda s: 6.0 * s * s}, left=0.36)
    assert tried == pytest.approx([5.0 / 3.0, 2.0]) and found == Told("near", pytest.approx(2.0), pytest.approx(24.0))
    # alike ones are told by their names
    assert told(monkeypatch, {"b": lambda s: 24.0, "a": lambda s: 24.0})[0] == Told("a", 1.0, 24.0)


def test_sizes_close_in_where_the_distance_grows_faster(monkeypatch):
    # with the fourth power: 1.5 at 1 promises 4, which is far too large; the power between the two leads to 2
    found, tried = told(monkeypatch, {"a": lambda s: 24.0 * (s / 2.0) ** 4})
    assert tried == pytest.approx([1.0, 4.0, 2.0]) and found == Told("a", pytest.approx(2.0), pytest.approx(24.0))
    # a distance that leaps never comes near: the smallest size that was seen to be enough is told
    found, tried = told(monkeypatch, {"a": lambda s: 1.0 if s < 3.0 else 600.0})
    assert len(tried) == 6 and found == Told("a", min(s for s in tried if s >= 3.0), 600.0)


@pytest.mark.parametrize(("off", "rounds"), [(0.19, 1), (0.21, 1), (-0.19, 1), (-0.21, 2)])
def test_a_fifth_off_is_near_enough(monkeypatch, off, rounds):
    found, tried = told(monkeypatch, {"a": lambda s: 24.0 * exp(off) * (s / 8.0) ** 2}, size=8.0)
    assert len(tried) == rounds and tried[0] == 8.0
    # never below the size that shows at all
    assert found.size == pytest.approx(8.0 if rounds == 1 else 8.0 * exp(0.105))


def test_six_rounds_are_tried_and_next_to_no_distance_goes_far(monkeypatch):
    found, tried = told(monkeypatch, {"a": lambda s: 1.0})
    assert tried == pytest.approx([24.0 ** (0.5 * k) for k in range(6)]) and found == Told("a", pytest.approx(24.0**2.5), 1.0)
    assert told(monkeypatch, {"a": lambda s: 0.0})[1] == pytest.approx([1.0, sqrt(24e3), 24e3, 24e3**1.5, 24e3**2, 1e9])


def test_a_size_ends_where_its_parameter_does(monkeypatch):
    found, tried = told(monkeypatch, {"a": lambda s: s}, most=3.0)
    assert tried == [1.0, 3.0] and found == Told("a", 3.0, 3.0) and not found.settled
    # where it is told at the size that shows, no smaller one is sought
    assert told(monkeypatch, {"a": lambda s: 30.0 * s}, size=2.0, most=2.0)[1] == [2.0]
    # where nothing is left by linear responses the size is large
    assert told(monkeypatch, {"a": lambda s: 24.0}, left=0.0)[1] == pytest.approx([1e3])
    assert told(monkeypatch, {"a": lambda s: 24.0}, left=0.0, most=500.0)[1] == pytest.approx([500.0])


def test_without_a_rival_the_first_size_is_told(monkeypatch):
    assert told(monkeypatch, {})[0] == Told(None, 1.0, np.inf) and DECIDABLE == 24.0


def test_a_size_goes_the_way_in_which_its_parameter_has_more_room(monkeypatch):
    asked = []
    monkeypatch.setattr(planning, "fit", lambda *args: asked.append(args) or "fit")
    parts = [free("a", 1.0, 2.0, 9.0), free("b", -5.0, 0.5, 1.0), free("c", -1.0, 0.0, 1.0), free("d", 0.0, 1.0, 2.0, shape=True)]
    own = SimpleNamespace(values=np.full(4, 7.0), free=parts, whiten="w", hypothesis="h", theta="t")
    for name, values in (("a", [5.0, 0.5, 0.0, 7.0]), ("b", [2.0, -2.5, 0.0, 7.0]), ("c", [2.0, 0.5, 3.0, 7.0])):
        assert planning._sized("sim", own, name, 3.0) == "fit"
        assert asked[-1][4].tolist() == values and asked[-1][5] == 0
    assert own.values.tolist() == [7.0] * 4
    assert [planning._reach(own, n) for n in "abc"] == [7.0, 5.5, 1.0]


@pytest.mark.parametrize(
    ("d2", "size", "settled", "shows"),
    [(18.0, 0.9, True, True), (17.9, 0.9, False, True), (24.0, 1.1, False, False), (24.0, 1.0, True, True)],
)
def test_a_row_is_in_the_units_of_the_recording_and_says_what_is_told(d2, size, settled, shows):
    p = get("zero_offset").parameter("z_out_act_n")
    reach = max(p.high - p.neutral, p.neutral - p.low)
    row = planning._row(Shown("zero_offset", p.name, "N", size * reach, 0.25), Told("gain_error", 3.0, d2), 10.0)
    assert (row.effect, row.parameter, row.unit, row.rival, row.d2) == ("zero_offset", p.name, "N", "gain_error", d2)
    assert row.least_size == pytest.approx(10.0 * size * reach) and row.gap_n == 2.5 and row.shows is shows
    assert row.told_size == (30.0 if settled else None)
    assert planning._row(Shown("zero_offset", p.name, "N", reach, 0.25), Told(None, 3.0, np.inf), 1.0).d2 is None


def test_what_cannot_be_told_apart_is_one_class_however_it_is_chained():
    def row(effect, rival, told_size=None, shows=True):
        return Planned(effect, "p", "N", 0.1, 0.1, shows, rival, told_size, 30.0)

    assert classes([row("c", "d"), row("a", "b"), row("d", "b"), row("e", "f")]) == [["a", "b", "c", "d"], ["e", "f"]]
    assert classes([row("a", None), row("a", "b", 0.5), row("a", "b", shows=False)]) == []


def test_the_start_from_which_the_smallest_gap_shows_is_kept(monkeypatch):
    starts = [np.array([1.0]), np.array([2.0]), np.array([3.0]), np.array([4.0])]
    gaps = {1.0: 0.3, 2.0: 0.1, 3.0: None, 4.0: 0.1}
    monkeypatch.setattr(planning, "full", lambda *_: SimpleNamespace(free=(), strengths=(1,)))
    monkeypatch.setattr(planning, "grid", lambda _: starts)
    monkeypatch.setattr(planning, "fit", lambda sim, whiten, h, theta, start, rounds: (float(start[0]), rounds))
    monkeypatch.setattr(planning, "replace", lambda found, singles: singles)

    def shown(singles, d2):
        ((w,),) = singles.values()
        gap = gaps[w.fit[0]]
        assert d2 == planning.learned().shows_d2 and w.fit[1] == 0 and (w.gain, w.evidence) == (0.0, 0.0)
        return [] if gap is None else [SimpleNamespace(gap_n=gap)]

    monkeypatch.setattr(planning, "least_shown", shown)
    found = SimpleNamespace(sim=SimpleNamespace(problem=SimpleNamespace(systems=())), base=SimpleNamespace(whiten=None, theta=None))
    assert planning._least(found, "viscous").fit[0] == 2.0
    gaps.update(dict.fromkeys(gaps))
    assert planning._least(found, "viscous") is None
    # what has no strength here has no start
    monkeypatch.setattr(planning, "full", lambda *_: SimpleNamespace(free=(), strengths=()))
    gaps[1.0] = 0.3
    assert planning._least(found, "viscous") is None


def made(hz=50.0, seconds=12.0, scale=1.0):
    runs = []
    for i, theta in enumerate((0.4, 0.6)):
        t = np.arange(0.0, seconds, 1.0 / hz)
        u = scale * np.interp(t, np.arange(0.0, seconds + 3.0, 3.0), np.tile([4.0, 22.0], 4)[: len(np.arange(0.0, seconds + 3.0, 3.0))])
        y = np.empty_like(u)
        last = np.exp(-theta) * u[0]
        for k, v in enumerate(u):
            last = y[k] = max(np.exp(-theta) * v, min(last, np.exp(theta) * v))
        runs.append(Run(f"r{i}", "act", t, u, y, config_id=f"c{i}"))
    return runs


def scenario(**more):
    bends = tuple(Configuration(id=f"c{i}", theta=t) for i, t in enumerate((0.4, 0.6)))
    return Scenario(noise=NoiseSection(white_n=0.02, coloured_n=0.01), configurations=bends, **more)


def test_planned_runs_stand_for_the_base_with_the_noise_that_is_expected():
    found, unit_n = planning._planned(made(), scenario())
    out = found.noise.output["act"]
    assert unit_n == 1.0 and (out.white_n, out.coloured_n) == (0.02, 0.01) and found.noise.input["act"] == out
    assert found.noise.smoother == {"act": 1.0} and found.measured is found.noise and found.base.hypothesis == NOTHING
    assert found.base.theta.tolist() == [0.4, 0.6] and not found.base.residual.any()
    # at twice the rate of the simulation a step holds the mean of two readings; ten times the tension is fitted in a larger unit
    fast, unit_n = planning._planned(made(2000.0, 3.0, scale=10.0), scenario())
    assert unit_n == 11.0 and fast.noise.output["act"].white_n == pytest.approx(0.02 / 11.0 / sqrt(2.0))
    assert fast.noise.output["act"].coloured_n == pytest.approx(0.01 / 11.0)
    quiet = planning._planned(made(), scenario().model_copy(update={"noise": NoiseSection(white_n=0.0)}))[0]
    assert quiet.noise.output["act"].white_n == 1e-6


def test_a_plan_lists_the_effects_of_the_output_by_the_gap_that_shows():
    told_of = []
    plan = planning.plan(made(), scenario(), ["zero_offset", "tension_loop_lag", "const_friction"], told_of.append)
    assert {r.effect for r in plan.rows} == {"zero_offset", "const_friction"} and sum(told_of) == pytest.approx(1.0)
    assert [r.gap_n for r in plan.rows] == sorted(r.gap_n for r in plan.rows) and 0.0 < plan.rows[0].gap_n < 0.02
    assert {r.rival for r in plan.rows} == {"zero_offset", "const_friction"} and plan.problem.configs == ("c0", "c1")
    for r in plan.rows:
        assert r.told_size is None or (r.told_size >= r.least_size and r.d2 >= 18.0)


def test_the_nearest_three_in_the_linear_picture_and_look_alikes_are_rivals(monkeypatch):
    left = {"viscous": 0.9, "slack": 0.8, "zero_offset": 0.7, "pulley_friction": 0.95, "const_friction": 0.85}
    asked = {}
    found = SimpleNamespace(singles={e: [SimpleNamespace(fit=f"fit of {e}")] for e in left})
    monkeypatch.setattr(planning, "widest", lambda found: found)
    monkeypatch.setattr(planning, "strengths", lambda found, fit: fit)
    monkeypatch.setattr(planning, "span", lambda columns: columns)
    monkeypatch.setattr(planning, "_left", lambda found, shown, spans: {e: left[e] for e in spans})
    monkeypatch.setattr(
        planning, "_told", lambda found, shown, rivals, least: asked.update(rivals=rivals, least=least) or Told(None, 1.0, 1.0)
    )
    shown = Shown("gain_error", "g_act", "1", 0.1, 0.1)
    assert list(planning.told_apart(found, [shown])) == [(shown, Told(None, 1.0, 1.0))]
    others = {n for n in ("pulley_friction", "viscous") if n in get("gain_error").look_alikes}
    assert asked["least"] == 0.7 and set(asked["rivals"]) == {"zero_offset", "slack", "const_friction"} | others
    assert asked["rivals"]["slack"] == "fit of slack"
    list(planning.told_apart(found, [shown], 1, alike=False))
    assert list(asked["rivals"]) == ["zero_offset"]

"""What to record next: within the rig's limits, written as it was judged, and honest where nothing settles it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from made_fits import NOISE_N, made, simulator

from sstl_cli.diagnosis import by_run
from sstl_cli.diagnosis.constants import MENU
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.following import Limits, best_experiment, isolability, rivals, sampling_s, scenario_of, table, within
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.hypotheses import Hypothesis, variants
from sstl_cli.diagnosis.verdict import Verdict
from sstl_cli.diagnosis.whitening import Noise, Sensor
from sstl_cli.physics.trajectories import SPAN_HZ

OFFSET = next(h for h in variants("zero_offset", ("act",)) if [f.parameter.name for f in h.free] == ["z_out_act_n"])
FRICTION = variants("const_friction", ("act",))[0]


def search():
    quiet = Sensor(NOISE_N, 0.0, 0.1)
    noise = Noise({"act": quiet}, {"act": quiet}, {"act": 1.0})
    models = {"zero_offset": (weighed(OFFSET, 0.05),), "const_friction": (weighed(FRICTION, 0.05),)}
    return Search(simulator(), noise, noise, made(), models, {})


def weighed(h, value):
    return Weighed(made(0.0, h, (value,) * len(h.free)), 0.0, 0.0)


def steepest(m):
    return float(np.abs(np.diff(m.tension_n)).max() / np.diff(m.time_s).max())


@pytest.mark.parametrize("trajectory", MENU, ids=lambda t: t.name)
@pytest.mark.parametrize("limits", [Limits(), Limits(15.0, 2.0), Limits(40.0, 30.0)])
def test_no_movement_leaves_the_limits_of_the_rig(trajectory, limits):
    movements = within(search(), trajectory, limits)
    # 12 N +- 9 N, at 2 pi 9 N / 7 s at most
    most, fastest = limits.tension_n or 21.1, limits.rate_n_per_s or 8.3
    for m in movements:
        assert m.tension_n.min() > 2.9 and m.tension_n.max() <= most + 1e-9
        assert steepest(m) <= fastest * 1.001
        assert np.allclose(np.diff(m.time_s), 0.02)
    if limits.rate_n_per_s == 30.0:
        assert movements and movements[0].tension_n.max() > 35.0


def test_a_random_movement_is_slowed_as_a_whole():
    """From its own frequencies, not from a chirp's: else it is made faster first, and its slow part far too slow."""
    random = next(t for t in MENU if t.kind == "random")
    (slow,) = within(search(), random, Limits(15.0, 2.0))
    low, top = SPAN_HZ["random"]
    share = slow.trajectory.frequency_hz / low
    assert 0.1 < share < 1.0 and slow.trajectory.top_frequency_hz / top == pytest.approx(share)


def test_what_is_written_is_what_was_judged():
    found = search()
    experiment = best_experiment(found, *(found.best((e,)) for e in ("zero_offset", "const_friction")))
    rows = [r.split(",") for r in table(scenario_of(found, experiment), 2.0).splitlines()]
    assert rows[0] == ["system", "time_s", "tension_in_n"]
    (m,) = experiment.movements
    assert [r[0] for r in rows[1:]] == ["act"] * len(m.time_s)
    assert np.allclose([float(r[2]) for r in rows[1:]], 2.0 * m.tension_n, rtol=1e-5, atol=1e-5)
    assert np.allclose([float(r[1]) for r in rows[1:]], m.time_s, atol=1e-3)


def test_two_names_for_one_model_are_settled_by_nothing():
    found = search()
    same = found.best(("zero_offset",))
    experiment = best_experiment(found, same, same)
    assert experiment.d2 < 1.0 and not experiment.settles


def test_how_alike_two_effects_look_is_the_cosine_of_what_theta_leaves_of_them():
    found = search()
    names, cosine = isolability(found)
    sim, base = simulator(), found.base
    columns = []
    for name in names:
        own, x = base.whiten(found.best((name,)).fit.jacobian).T
        thetas = (sim.config[:, None] == np.arange(2)) * own[:, None]
        columns.append(x - thetas @ np.linalg.lstsq(thetas, x, rcond=None)[0])
    a, b = columns
    alike = abs(a @ b) / np.sqrt((a @ a) * (b @ b))
    assert sorted(names) == ["const_friction", "zero_offset"]
    assert cosine == pytest.approx(np.array([[1.0, alike], [alike, 1.0]]))
    # of the most evident only
    assert isolability(found, 1)[1].shape == (1, 1)


def test_a_plan_is_sampled_as_fast_as_the_log_but_no_faster_than_a_line_shows():
    found = search()
    assert sampling_s(found) == pytest.approx(0.02)
    experiment = best_experiment(found, *(found.best((e,)) for e in ("zero_offset", "const_friction")), Limits(15.0, 20.0))
    assert (
        experiment.separates == ("zero_offset", "const_friction") and experiment.d2 > 0.0 and experiment.settles == (experiment.d2 >= 24.0)
    )
    assert experiment.trajectory is experiment.movements[0].trajectory and experiment.movements[0].tension_n.max() <= 15.0 + 1e-9
    scenario = scenario_of(found, experiment)
    assert [c.id for c in scenario.configurations] == ["a", "b"] and scenario.sampling_hz == pytest.approx(50.0)
    assert [c.theta for c in scenario.configurations] == pytest.approx([0.5, 0.6])


def test_the_rivals_that_are_to_be_parted_are_those_of_the_group():
    ids = [("viscous",), ("stribeck",), ("presliding",), ("slack", "viscous")]
    models = [SimpleNamespace(ids=i, fit=SimpleNamespace(hypothesis=Hypothesis(i, ()))) for i in ids]
    # what is a run's own says nothing of another movement
    models.append(SimpleNamespace(ids=("friction_drift",), fit=SimpleNamespace(hypothesis=by_run.scatter(by_run.FRICTION))))
    p = dict(zip(ids, (0.5, 0.2, 0.15, 0.1), strict=True))
    said = Verdict("ambiguous", ids[0], 0.8, (ids[0], ids[2], ids[3]), p, "")
    assert [w.ids for w in rivals(models, said)] == [("viscous",), ("presliding",), ("stribeck",)]
    unknown = Verdict("unknown", (), 0.8, (), p, "")
    assert [w.ids for w in rivals(models, unknown)] == ids[:3]

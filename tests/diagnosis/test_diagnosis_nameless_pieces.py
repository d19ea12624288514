"""Friction of the loop's own on small records of the fast model: its size, what it is compared with, and the words for it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from made_fits import NOTHING, made, simulator

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import nameless
from sstl_cli.diagnosis.evidence import Weighed, weigh
from sstl_cli.diagnosis.fit import fit, settle
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.free import LOOP
from sstl_cli.diagnosis.hypotheses import variants
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Noise, Sensor, white
from sstl_cli.physics.scenario import Scenario
from sstl_cli.physics.transmission.play import play_operator

NOISE_N, MORE = 0.02, 0.06
QUIET = Sensor(NOISE_N, 0.0, 0.1)
NOISE = Noise(*({"act": QUIET, "sstl": QUIET} for _ in range(2)), {"act": 1.0, "sstl": 1.0})
NAMED = ("pulley_friction", "zero_offset")


@cache
def searched(more: float = MORE) -> Search:
    """Return single effects fitted to two bends of a rig whose loop rubs more, by the fast model."""
    t, rng, runs = np.arange(0.0, 30.0, 0.02), np.random.default_rng(5), []
    for config, theta in (("a", 0.35), ("b", 0.55)):
        for system in ("act", "sstl"):
            u = 14.0 + 11.0 * np.sin(2.0 * np.pi * t / 7.0 + theta)
            angle = theta * (2.0 * (1.0 + more) if system == "sstl" else 1.0)
            out = play_operator(u, np.exp(-angle), 0.0, np.exp(angle), 0.0, u[0])
            runs.append(
                Run(f"{config}{system}", system, t, *(x + NOISE_N * rng.standard_normal(len(t)) for x in (u, out)), config_id=config)
            )
    sim = Simulator(prepare(runs), Scenario().rig.mechanics())
    plain = white(NOISE_N, sim.weight, [s.start for s in sim.slices()])
    base = settle(sim, NOISE, fit(sim, plain, NOTHING, np.array([0.35, 0.55]), np.zeros(0)))
    found = Search(sim, NOISE, NOISE, base, {}, {})
    for effect_id in NAMED:
        h = variants(effect_id, sim.problem.systems)[-1]
        start = fit(sim, base.whiten, h, base.theta, np.array([f.parameter.neutral for f in h.free]) + 0.01)
        found.singles[effect_id] = (weigh(sim, settle(sim, NOISE, start), base),)
    return found


def test_it_is_found_to_size_alone_and_beside_the_leading_effects():
    found = nameless.beside(searched(), 2, 1)
    assert {w.ids for w in found.nameless} == {(LOOP.id,), *((i, LOOP.id) for i in NAMED)}
    alone = found.best((LOOP.id,))
    assert alone.fit.values == pytest.approx([MORE], abs=0.004) and alone.fit.theta == pytest.approx([0.35, 0.55], abs=0.004)
    assert nameless.leading(found) is alone and found.sim.loop_friction(alone.fit.effects) == pytest.approx(1.0 + MORE, abs=0.004)
    assert found.sim.loop_friction(found.base.effects) == 1.0
    assert nameless.words(found)[LOOP.id].startswith(f"friction of the sensing loop that is {100.0 * alone.fit.values[0]:.1f} % above")
    # it is among what lacks one effect of a pair, and what has a name is listed without it
    pair = found.best(("zero_offset", LOOP.id))
    assert {p.ids for p in found.parts(pair.ids)} == {(LOOP.id,), ("zero_offset",)}
    assert {w.ids for w in found.ranked()} == {(i,) for i in NAMED} and found.every()[0] in found.nameless
    # with one effect at a time it stands alone
    assert [w.ids for w in nameless.beside(searched(), 1, 1).nameless] == [(LOOP.id,)]


def test_nothing_is_said_where_the_loop_rubs_as_the_tendon_does():
    found = nameless.beside(searched(0.0), 1, 1)
    alone = found.best((LOOP.id,))
    assert abs(alone.fit.values[0]) < 0.004 and alone.evidence < 3.0 and nameless.leading(found) is None


def test_one_tendon_alone_or_a_rig_that_is_known_is_not_asked():
    sim = simulator()
    found = Search(sim, NOISE, NOISE, made(), {}, {})
    assert nameless.beside(found, 2, 1) is found and nameless.words(found) == {} and nameless.leading(found) is None
    known = searched()
    records = tuple(replace(r, misfit_n=np.full(len(r), 0.01)) for r in known.sim.problem.records)
    known = replace(known, sim=replace(known.sim, problem=replace(known.sim.problem, records=records)))
    assert known.sim.scatters and nameless.beside(known, 2, 1) is known


def test_what_the_simulator_has_is_said_beside_it_and_who_has_a_name_goes_before_at_even_odds():
    sim = simulator()
    less = Weighed(replace(made(), hypothesis=nameless.HYPOTHESIS, values=np.array([-0.05])), 10.0, 5.0)
    asked = Search(sim, NOISE, NOISE, made(), {}, {}, (less,))
    assert nameless.words(asked) == {LOOP.id: "friction of the sensing loop that is 5.0 % below the actuation tendon's"}
    knows = replace(asked, sim=replace(sim, mechanics=replace(sim.mechanics, loop_friction=1.1)))
    assert nameless.words(knows)[LOOP.id].endswith("is 4.5 % above the actuation tendon's, where the simulator has +10.0 %")
    # 49 to 1
    assert nameless.leading(asked) is less
    assert nameless.leading(replace(asked, singles={"viscous": (Weighed(made(), 10.0, 2.0),)})) is None

"""The march of elastic lines side by side: what a plain march of each says, whatever goes beside it."""

import itertools

import numpy as np
import pytest
from line_reference import marched as reference
from soon import asked

from sstl_cli.physics.effect import Law, Mechanics, Transition
from sstl_cli.physics.transmission.lanes import WIDTH
from sstl_cli.physics.transmission.line import elastic_lines, geometry, marched
from sstl_cli.physics.transmission.state import Input

# longest of a run, and more lines of either system than there are lanes
KNOTS, RUNS = 60, 2 * WIDTH + 5
FRICTION = {
    "rigid": lambda r: ({}, {}),
    "presliding": lambda r: ({}, {"breakaway_mm": r(0.01, 0.5), "spread": r(0.0, 1.0)}),
    "drag": lambda r: ({}, {"drag_n_s_mm": r(0.0, 0.05), "drag_bend_n_s_mm": r(0.0, 0.05)}),
    "creep": lambda r: ({}, {"creep_fraction": r(0.01, 0.3), "creep_s": r(0.1, 30.0)}),
    "spread": lambda r: ({}, {"creep_fraction": r(0.01, 0.3), "creep_s": r(0.1, 30.0), "creep_spread": r(1.0, 10.0)}),
    "static": lambda r: ({}, {"breakaway_mm": r(0.05, 0.3), "static_ratio": r(1.0, 1.5), "static_mm_s": r(0.1, 2.0)}),
    "aging": lambda r: ({}, {"breakaway_mm": r(0.05, 0.3), "aging": r(0.01, 0.1), "aging_s": r(0.1, 2.0)}),
    "stribeck": lambda r: ({}, {"breakaway_mm": r(0.05, 0.3), "stribeck_ratio": r(1.0, 1.2), "stribeck_mm_s": r(5.0, 30.0)}),
    "pulley": lambda r: ({"pulley_pull": r(0.0, 0.2), "pulley_release": r(0.0, 0.2), "pulley_n": r(0.0, 0.3)}, {}),
    "asymmetric": lambda r: ({"scale_pull": r(0.7, 1.0), "scale_release": r(1.0, 1.3), "constant_n": r(0.0, 0.5)}, {}),
    "load": lambda r: (
        {"adhesion_n": r(0.0, 0.5), "factors": [lambda t, c=r(-0.02, 0.02): np.maximum(1.0 + c * t, 0.1)]},
        {"breakaway_mm": r(0.0, 0.2)},
    ),
    "bristle": lambda r: ({}, {"breakaway_mm": r(0.05, 0.5), "spread": r(0.0, 0.5), "bristle_n": 10.0}),
    "thinning": lambda r: ({}, {"drag_n_s_mm": r(0.0, 0.05), "drag_power": r(0.4, 1.0)}),
    "dahl": lambda r: ({}, {"breakaway_mm": r(0.05, 0.5), "spread": r(0.0, 0.5), "tail": 1.0}),
    "between": lambda r: ({}, {"breakaway_mm": r(0.05, 0.5), "tail": r(0.1, 0.9), "drag_n_s_mm": r(0.0, 0.02)}),
    "ending": lambda r: ({"constant_n": r(0.0, 0.3)}, {"breakaway_mm": r(0.05, 0.5), "tail": 0.0, "creep_fraction": r(0.0, 0.2)}),
}
SMOOTH = ("dahl", "between", "ending")


def runs(seed, friction, scaled=False):
    """Return what goes into lines of both systems, unlike in length, bend and friction, and the lines."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(3, KNOTS, RUNS)
    edges = np.concatenate(([0], np.cumsum(lengths)))
    tension = np.concatenate([np.interp(np.arange(n), np.linspace(0, n, 7), rng.uniform(0.5, 30.0, 7)) for n in lengths])
    steps, scale = rng.choice([0.01, 0.02], edges[-1]), rng.uniform(0.8, 1.2, edges[-1]) if scaled else np.ones(1)
    into = Input(tension, edges, np.concatenate([np.arange(n) for n in lengths]), edges, steps, scale)
    places = geometry([(str(rng.choice(["act", "sstl"])), str(rng.choice(["NP", "CP", "ND"]))) for _ in lengths], Mechanics())
    theta, start = rng.uniform(0.1, 1.2, RUNS), rng.uniform(0.5, 20.0, RUNS)
    made = [FRICTION[friction](rng.uniform) for _ in lengths]
    lines = elastic_lines(
        into, places, rng.uniform(0.05, 0.5, len(theta)), theta, Law(**made[0][0]), [Transition(**m[1]) for m in made], start
    )
    return into, lines


# one line of each kind of friction by its own mu in every run of the suite, those of one mu beside the rigid one slowly
@pytest.mark.parametrize(
    ("friction", "scaled"),
    asked(itertools.product(FRICTION, (True, False)), *((f, True) for f in FRICTION), ("rigid", False), several=True),
)
def test_lines_side_by_side_are_those_of_a_plain_march(friction, scaled):
    into, lines = runs(len(friction), friction, scaled)
    out = marched([(into, lines)])[0]
    for i, (a, b) in enumerate(zip(into.edges[:-1], into.edges[1:], strict=True)):
        scale = into.scale[a:b] if scaled else np.ones(b - a)
        plain = reference(into.tension[a:b], into.steps[a:b], scale, lines, i)
        # one whose friction builds up smoothly is followed to its own balance, at every node and knot
        assert out[a:b] == pytest.approx(plain, abs=1e-3 if friction in SMOOTH else 1e-9), (i, b - a)


@pytest.mark.parametrize("friction", ["presliding", "creep", "spread", "aging", "stribeck", "load", "between"])
def test_a_line_answers_the_same_whatever_goes_beside_it(friction):
    cases = [runs(1, friction), runs(1, "drag"), runs(1, friction, scaled=True)]
    # what goes in is alike but for the factor on mu
    together = marched(cases)
    for case, out in zip(cases, together, strict=True):
        assert (marched([case])[0] == out).all()
    into, lines = cases[0]
    a, b = into.edges[4:6]
    one = Input(into.tension[a:b], np.array([0, b - a]), into.knots[a:b], np.array([0, b - a]), into.steps[a:b], into.scale)
    assert (marched([(one, type(lines)(*(x[4:5] for x in lines)))])[0] == together[0][a:b]).all()

"""The course of a search on stand-ins: what begins where, who is followed how far, and what is looked at in which order."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.diagnosis import search as of


@dataclass(frozen=True)
class Model:
    """A fit: its name, and what it costs."""

    ids: tuple[str, ...] = ()
    cost: float = 0.0
    how: tuple = ()
    free: tuple = ()
    theta: np.ndarray = field(default_factory=lambda: np.zeros(2))
    values: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def hypothesis(self):
        return SimpleNamespace(ids=self.ids, free=self.free, strengths=self.free)


BASE = Model(cost=100.0)


def test_a_fit_below_the_base_is_kept_and_another_begins_once_more_near_it(monkeypatch):
    near = []
    monkeypatch.setattr(of, "_near", lambda found, f, *more: near.append(more) or Model(("near",), f.cost - 3.0))
    found = SimpleNamespace(base=BASE, sim=None, noise=None)
    good, bad = Model(("a",), 99.0), Model(("a",), 100.0)
    assert of._containing(found, good) is good and near == []
    assert of._containing(found, bad).ids == ("near",) and near == [(5, 2)]
    monkeypatch.setattr(of, "settle", lambda sim, noise, start, judged=False: start)
    assert of._settled(found, good) is good and of._settled(found, bad).ids == ("near",) and near[1:] == [()]
    monkeypatch.setattr(of, "_near", lambda found, f, *more: Model(("near",), f.cost + 3.0))
    assert of._containing(found, bad) is bad is of._settled(found, bad)


def test_unwhitened_fits_follow_the_promising_ones_further_and_are_told_the_best_first(monkeypatch):
    gains = {"a": 100.0, "b": 31.0, "c": 29.0, "d": 90.0, "e": 80.0, "f": 70.0, "g": 30.0}
    fits, shares = [], []

    def fit(sim, whiten, h, theta, values, iterations, careful):
        fits.append((h if isinstance(h, str) else "base", iterations, careful))
        return Model(("base",), 0.0, theta=theta + 1.0) if not isinstance(h, str) else Model((h,), -gains[h], theta=theta)

    monkeypatch.setattr(of, "_plain", lambda sim, scale: scale)
    monkeypatch.setattr(of, "fit", fit)
    monkeypatch.setattr(of, "screen", lambda sim, base, h: (gains[h], np.zeros(1)))
    monkeypatch.setattr(of, "by_gain", lambda sim, h: None)
    found, theta = of._rough("small", list(gains), np.zeros(2), 0.5, shares.append, 1)
    assert fits[0] == ("base", 4, True) and theta.tolist() == [1.0, 1.0]
    # four lead, and whoever promises more than three tenths of the best
    assert fits[1:] == [("a", 5, True), ("d", 5, True), ("e", 5, True), ("f", 5, True), ("b", 5, True), ("g", 2, True), ("c", 2, True)]
    assert [f.ids[0] for f in found] == list("adefbgc") and sum(shares) == pytest.approx(0.2 + 0.3)


@pytest.mark.parametrize(("likely", "judged"), [(3.0, True), (5.0, False)])
def test_hypotheses_that_have_lost_are_weighed_as_they_are(monkeypatch, likely, judged):
    asked = []
    monkeypatch.setattr(
        of, "_settled", lambda found, f, judged=False: asked.append((f.ids, judged)) or Model(f.ids, f.cost - 1.0, free=f.free)
    )
    monkeypatch.setattr(of, "weigh", lambda sim, f, base: SimpleNamespace(fit=f, evidence=-f.cost, ids=f.ids))
    monkeypatch.setattr(of, "of_other_laws", lambda effect: {"law"})
    part = SimpleNamespace(parameter=SimpleNamespace(name="z"))
    other = SimpleNamespace(parameter=SimpleNamespace(name="law"))
    found = SimpleNamespace(sim=None, base=BASE)
    begun = [Model(("zero_offset",), 96.0, free=(part,)), Model(("zero_offset",), 90.0, free=(other, part))]
    weighed = of._weighed(found, begun, likely)
    # gains of 4 and 10 nats; of what is asked for by the usual law alone subsets would be looked at
    assert asked == ([(("zero_offset",), True)] * 2 if judged else [(("zero_offset",), True)])
    assert [w.evidence for w in weighed] == [-89.0, -95.0 if judged else -96.0]


def test_subsets_of_a_whole_that_was_followed_are_fitted_from_where_they_stand_in_it(monkeypatch):
    parts = tuple(SimpleNamespace(parameter=SimpleNamespace(name=n)) for n in "ab")
    monkeypatch.setattr(of, "_settled", lambda found, f, judged=False: f)
    monkeypatch.setattr(of, "weigh", lambda sim, f, base: SimpleNamespace(fit=f, evidence=-f.cost))
    monkeypatch.setattr(of, "of_other_laws", lambda effect: set())
    monkeypatch.setattr(of, "_subsets", lambda sim, whole: [("h", "values", "theta")])
    monkeypatch.setattr(of, "fit", lambda sim, whiten, h, theta, values, rounds: Model((h, theta, values, str(rounds)), 50.0))
    whole = replace(Model(("zero_offset",), 60.0, free=parts))
    object.__setattr__(whole, "whiten", None)
    found = SimpleNamespace(sim=None, base=BASE)
    assert [w.fit.ids for w in of._weighed(found, [whole], 10.0)] == [("h", "theta", "values", "0"), ("zero_offset",)]
    # not of one that has lost, of one strength, or of an effect with laws of its own
    assert len(of._weighed(found, [whole], 40.0)) == 1 == len(of._weighed(found, [Model(("zero_offset",), 60.0, free=parts[:1])], 10.0))
    assert len(of._weighed(found, [Model(("presliding",), 60.0, free=parts)], 10.0)) == 1


def searched(monkeypatch, costs, most=3, passed=(), fitted=(1, 1, 1), combined=()):
    """Return the course of a search whose first fits cost so much."""
    course, left = [], iter(fitted)
    found = SimpleNamespace(base=BASE, singles={}, combined=dict.fromkeys(combined))
    first = [Model((i,), c) for i, c in costs]
    monkeypatch.setattr(of, "starting", lambda i, systems: [f"{i}{k}" for k in range(2)])
    monkeypatch.setattr(of, "_as_known", lambda sim, starts: course.append(list(starts)) or starts)
    monkeypatch.setattr(of, "_begun", lambda sim, starts, theta, advance, workers: (found, first))

    def weighed(found, group, least):
        course.append((group[0].ids[0], len(group), least))
        return (SimpleNamespace(ids=group[0].ids),)

    def combine(found, size, workers):
        course.append(f"combine {size}")
        return next(left)

    monkeypatch.setattr(of, "_weighed", weighed)
    monkeypatch.setattr(of, "combine", combine)
    monkeypatch.setattr(of.shared, "loosened", lambda found, workers: course.append("loosened") or found)
    monkeypatch.setattr(of.again, "beside_the_best", lambda found, most, workers: course.append(f"again {most}") or found)
    monkeypatch.setattr(of.by_run, "add", lambda found, most: course.append(f"runs {most}"))
    monkeypatch.setattr(of.usual, "beyond", lambda found: course.append("usual") or found)
    monkeypatch.setattr(of.nameless, "beside", lambda found, most, workers: course.append(f"nameless {most}") or found)
    shares = []
    sim = SimpleNamespace(problem=SimpleNamespace(systems=("act",)))
    assert of.run(sim, ["b", "a"], None, most, shares.append, 1, lambda stage: stage in passed) is found
    return course, shares


def test_a_search_goes_from_singles_to_triples_and_says_how_far_it_is(monkeypatch):
    course, shares = searched(monkeypatch, [("b", 40.0), ("a", 90.0), ("b", 45.0), ("c", 70.0)], combined=["pair"])
    # the best gains 60 nats: who gains less than 20 has lost, as forty behind are more than seven tenths
    assert course[0] == ["b0", "b1", "a0", "a1"] and course[1:4] == [("a", 1, 18.0), ("b", 2, 18.0), ("c", 1, 18.0)]
    assert course[4:] == ["loosened", "combine 2", "again 3", "combine 3", "runs 3", "usual", "nameless 3"]
    assert shares == pytest.approx([0.3 / 4, 0.6 / 4, 0.3 / 4, 0.1, 0.1])


@pytest.mark.parametrize(
    ("how", "rest"),
    [
        ({"most": 1}, ["again 1", "runs 1"]), ({"passed": ("pairs",)}, ["combine 3", "again 3", "runs 3"]), ({"fitted": (0,)}, ["combine 2", "again 3", "runs 3"]),
        ({"passed": ("pairs", "triples")}, ["again 3", "runs 3"]), ({"most": 2}, ["combine 2", "again 2", "again 2", "runs 2"]),
    ],
)  # fmt: skip
def test_what_has_no_time_or_finds_nothing_is_left_out(monkeypatch, how, rest):
    course, _ = searched(monkeypatch, [("a", 90.0), ("b", 95.0), ("c", 99.0)], **how)
    # the best gains 10 nats: nobody has lost by forty
    assert course[1] == ("a", 1, -30.0) and course[4:-2] == ["loosened", *rest]


def test_as_many_stand_together_as_there_are(monkeypatch):
    assert "combine 3" not in searched(monkeypatch, [("a", 90.0), ("b", 95.0)])[0]

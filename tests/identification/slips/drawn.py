"""Slips of drawn size on logs of drawn rigs: what a table of gate verdicts is made from, one slip a log."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from slips import wrong as w
from slips.wide import wide
from sstl_cli.core.runs import Run

Log = list[Run]
Rng = np.random.Generator
UNITS_N = {"kN": 1e3, "lbf": 4.4482216, "kgf": 9.80665, "mN": 1e-3, "gf": 9.80665e-3}


@dataclass(frozen=True)
class Drawn:
    """A log spoilt by one slip: the name, the rules whose words are right, the sound log and the wrong one."""

    name: str
    rules: tuple[str, ...]
    sound: Log
    wrong: Log


def span(log: Log) -> float:
    return max(float(np.ptp(r.tension_in_n)) for r in log)


def largest(log: Log) -> float:
    return max(float(r.tension_in_n.max()) for r in log)


def duration(log: Log) -> float:
    return min(float(r.time_s[-1]) for r in log if "trapezoid" in r.run_id)


def sized(low: float, high: float, seed: int, **wishes: object) -> Log:
    """Return the first wide log from ``seed`` on whose largest tension (N) lies between two limits."""
    for k in range(200):
        log = wide(seed + 7919 * k, moves=("trapezoid",), **wishes)  # type: ignore[arg-type]
        if low <= largest(log) <= high and any(r.trajectory == "trapezoid" for r in log):
            return log
    raise RuntimeError("no rig of this size")


def units(log: Log, rng: Rng, unit: str, which: str) -> Log:
    f = 1.0 / UNITS_N[unit]
    return w.every(w.scale(f if "in" in which else 1.0, f if "out" in which else 1.0))(log, rng)


def counts(log: Log, rng: Rng, both: bool) -> Log:
    bits = int(rng.integers(12, 25))
    gain = 2.0**bits / (float(rng.uniform(1.5, 4.0)) * largest(log))
    zero = float(rng.uniform(0.0, 0.3)) * 2.0**bits
    return w.every(w.counts(gain if both else None, gain * float(rng.uniform(0.8, 1.2)), zero))(log, rng)


def shifted(by: float) -> Callable[[Run], Run]:
    """Move the output's clock, and keep what both clocks cover."""

    def change(r: Run) -> Run:
        t = r.time_s
        keep = (t + by >= t[0]) & (t + by <= t[-1])
        cut = {n: v[keep] for n in ("position_in_mm", "tension_ref_n") if (v := getattr(r, n)) is not None}
        moved = np.interp(t[keep] + by, t, r.tension_out_n)
        return replace(r, time_s=t[keep] - t[keep][0], tension_in_n=r.tension_in_n[keep], tension_out_n=moved, **cut)

    return change


def early(log: Log, rng: Rng, sign: float) -> Log:
    return w.every(shifted(sign * float(rng.uniform(0.015, 0.05)) * duration(log)))(log, rng)


def late(log: Log, rng: Rng) -> Log:
    return w.every(shifted(-max(0.6, float(rng.uniform(0.03, 0.08)) * duration(log))))(log, rng)


def zeroed(log: Log, rng: Rng, channel: str, sign: float) -> Log:
    by = sign * float(rng.uniform(0.25, 0.45)) * span(log)
    return w.every(w.scale(1.0, 1.0, by if channel == "in" else 0.0, by if channel == "out" else 0.0))(log, rng)


def one_gain(log: Log, rng: Rng) -> Log:
    return w.one(w.scale(1.0, float(rng.choice([0.55, 0.6, 1.6, 1.8]))))(log, rng)


def stuck(log: Log, rng: Rng) -> Log:
    a = float(rng.uniform(0.1, 0.4))
    return w.one(w.held_from(a, a + float(rng.uniform(0.35, 0.55))))(log, rng)


BOTH = ("act", "sstl")
# name, rules whose words are right, the slip, and what rig it needs
Kind = tuple[str, tuple[str, ...], Callable[[Log, Rng], Log], dict[str, object]]
KINDS: tuple[Kind, ...] = (
    ("counts for both", ("counts", "magnitude"), lambda g, r: counts(g, r, True), {}),
    ("counts for the output", ("counts", "gain"), lambda g, r: counts(g, r, False), {}),
    ("kN for both", ("magnitude", "reference"), lambda g, r: units(g, r, "kN", "in out"), {"sizes": (2.0, 45.0)}),
    ("mN for both", ("magnitude", "reference"), lambda g, r: units(g, r, "mN", "in out"), {"sizes": (3.0, 500.0)}),
    ("gf for both", ("magnitude", "reference"), lambda g, r: units(g, r, "gf", "in out"), {"sizes": (9.0, 500.0)}),
    ("kN for the output", ("gain", "magnitude"), lambda g, r: units(g, r, "kN", "out"), {}),
    ("mN for the input", ("gain", "magnitude", "reference"), lambda g, r: units(g, r, "mN", "in"), {}),
    ("lbf for the input", ("gain", "reference"), lambda g, r: units(g, r, "lbf", "in"), {}),
    ("lbf for the output", ("gain",), lambda g, r: units(g, r, "lbf", "out"), {}),
    ("kgf for the output", ("gain",), lambda g, r: units(g, r, "kgf", "out"), {}),
    ("lbf in one file", ("unit_between_runs", "reference", "gain"), w.one(w.scale(1 / w.LBF, 1 / w.LBF)), {"leads": 3}),
    ("kN in one file", ("unit_between_runs", "reference", "magnitude"), w.one(w.scale(1e-3, 1e-3)), {"leads": 3}),
    ("output negative", ("sign",), w.every(w.scale(1.0, -1.0)), {}),
    ("input negative", ("sign",), w.every(w.scale(-1.0, 1.0)), {}),
    ("both negative", ("sign",), w.every(w.scale(-1.0, -1.0)), {}),
    ("output flipped and zeroed anew", ("sign",), lambda g, r: w.every(w.scale(1.0, -1.0, 0.0, 1.3 * largest(g)))(g, r), {}),
    ("one run negative", ("sign",), w.one(w.scale(1.0, -1.0)), {}),
    ("swapped", ("swapped",), w.every(w.swap), {}),
    ("swapped in one run", ("swapped",), w.one(w.swap), {}),
    ("ms as s", ("time_unit",), w.every(w.timed(1e3)), {}),
    ("us as s", ("time_unit",), w.every(w.timed(1e6)), {}),
    ("sample index as time", ("time_unit",), w.every(lambda r: replace(r, time_s=np.arange(len(r), dtype=float))), {}),
    ("ms in one file", ("rate", "time_unit"), w.one(w.timed(1e3)), {}),
    ("one file at another rate", ("rate",), lambda g, r: w.one(w.timed(float(r.choice([0.4, 0.5, 2.0, 2.5, 5.0]))))(g, r), {"leads": 3}),
    ("act and sstl exchanged", ("passes",), w.every(w.exchanged), {"systems": BOTH}),
    ("an act run labelled sstl", ("passes", "duplicate"), w.one(w.as_system("sstl"), w.act), {"systems": BOTH}),
    ("an sstl run labelled act", ("passes",), w.one(w.as_system("act"), w.sstl), {"systems": BOTH}),
    ("configurations of sstl reversed", w.LABEL, w.relabelled(w.reverse, w.sstl, lead=True), {"systems": BOTH, "leads": 3}),
    ("files shuffled over seven bends", w.LABEL, w.relabelled(w.shuffle, lead=True), {"leads": 7, "systems": ("act",)}),
    ("two bends of seven exchanged", w.LABEL, w.relabelled(w.exchange, lead=True), {"leads": 7, "systems": ("act",)}),
    ("a run twice", ("duplicate",), w.copied(lambda r: r), {}),
    ("a part of a run once more", ("duplicate",), w.copied(w.tail), {}),
    ("a run once more in lbf", ("duplicate", "unit_between_runs"), w.copied(w.scale(1 / w.LBF, 1 / w.LBF)), {}),
    ("two rigs, other sensors", ("odd_run", "duplicate"), w.two_rigs, {"leads": 3}),
    ("output of one run at another gain", ("odd_run", "gain"), one_gain, {"leads": 3}),
    ("output early", ("lead",), lambda g, r: early(g, r, 1.0), {}),
    ("output late", ("lead",), late, {}),
    ("output's clock at another speed", ("drift",), lambda g, r: w.every(w.drifting(float(r.choice([-0.02, 0.02, 0.03]))))(g, r), {}),
    ("output tared under load", ("zero", "sign"), lambda g, r: zeroed(g, r, "out", -1.0), {"sizes": (15.0, 500.0)}),
    ("input tared under load", ("zero", "sign"), lambda g, r: zeroed(g, r, "in", -1.0), {"sizes": (15.0, 500.0)}),
    ("output too high", ("zero",), lambda g, r: zeroed(g, r, "out", 1.0), {"sizes": (25.0, 500.0)}),
    ("output stuck", ("stuck",), stuck, {}),
    ("output constant", ("stuck",), w.one(lambda r: replace(r, tension_out_n=np.full(len(r), 0.3 * float(r.tension_in_n.max())))), {}),
    ("one column twice", ("same_channel",), w.every(lambda r: replace(r, tension_out_n=r.tension_in_n)), {}),
    ("clock taken for the input", ("clock_channel",), w.every(lambda r: replace(r, tension_in_n=r.time_s)), {}),
)  # fmt: skip


def draw(seed: int, kinds: Sequence[Kind] = KINDS) -> Iterator[Drawn]:
    """Yield every slip once, of a size and on a rig drawn from the seed."""
    for number, (name, rules, spoil, wishes) in enumerate(kinds):
        rng = np.random.default_rng((seed, number, 5))
        given = dict(wishes)
        low, high = given.pop("sizes", (0.0, 1e9))  # type: ignore[misc]
        log = sized(low, high, 100_000 * seed + 1000 * number, effects=int(rng.integers(0, 2)), **given)
        yield Drawn(name, rules, log, spoil(log, rng))

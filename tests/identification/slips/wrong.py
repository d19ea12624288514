"""Slips: what goes wrong between a sound recording and its log, one at a time, and the rules that tell it rightly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from slips.sound import draw
from sstl_cli.core.runs import Run

LBF, KGF, GF = 4.4482216, 9.80665, 0.00980665
Log = list[Run]


@dataclass(frozen=True)
class Slip:
    """One slip: its name, the rules whose words are right, and how it spoils a log (with random numbers)."""

    name: str
    rules: tuple[str, ...]
    spoil: Callable[[Log, np.random.Generator], Log]
    leads: int | None = None
    systems: tuple[str, ...] = ("act", "sstl")


def scale(fx: float, fy: float, zx: float = 0.0, zy: float = 0.0) -> Callable[[Run], Run]:
    return lambda r: replace(r, tension_in_n=fx * r.tension_in_n + zx, tension_out_n=fy * r.tension_out_n + zy)


def counts(gx: float | None, gy: float | None, zero: float) -> Callable[[Run], Run]:
    def change(r: Run) -> Run:
        x, y = r.tension_in_n, r.tension_out_n
        return replace(
            r, tension_in_n=x if gx is None else np.round(gx * x + zero), tension_out_n=y if gy is None else np.round(gy * y + zero)
        )

    return change


def shifted(by: float) -> Callable[[Run], Run]:
    return lambda r: replace(r, tension_out_n=np.interp(r.time_s + by, r.time_s, r.tension_out_n))


def timed(factor: float) -> Callable[[Run], Run]:
    return lambda r: replace(r, time_s=factor * r.time_s)


def drifting(rate: float) -> Callable[[Run], Run]:
    return lambda r: replace(r, tension_out_n=np.interp(r.time_s * (1.0 - rate), r.time_s, r.tension_out_n))


def swap(r: Run) -> Run:
    return replace(r, tension_in_n=r.tension_out_n, tension_out_n=r.tension_in_n)


def every(change: Callable[[Run], Run], which: Callable[[Run], bool] = lambda r: True) -> Callable[[Log, np.random.Generator], Log]:
    return lambda log, rng: [change(r) if which(r) else r for r in log]


def one(change: Callable[[Run], Run], which: Callable[[Run], bool] = lambda r: True) -> Callable[[Log, np.random.Generator], Log]:
    """Spoil one run of those that move most."""

    def spoil(log: Log, rng: np.random.Generator) -> Log:
        fit = [i for i, r in enumerate(log) if which(r) and "trapezoid" in r.run_id]
        at = int(rng.choice(fit))
        return [change(r) if i == at else r for i, r in enumerate(log)]

    return spoil


def configs(log: Log) -> list[str]:
    return sorted({str(r.config_id) for r in log})


def relabelled(order: Callable[[list[str], np.random.Generator], list[str]], which: Callable[[Run], bool] = lambda r: True,
               lead: bool = False) -> Callable[[Log, np.random.Generator], Log]:  # fmt: skip
    """Give runs the configuration (and lead) of another."""

    def spoil(log: Log, rng: np.random.Generator) -> Log:
        names = configs(log)
        new = dict(zip(names, order(names, rng), strict=True))
        leads = {str(r.config_id): r.lead_mm for r in log}
        return [
            replace(r, config_id=new[str(r.config_id)], lead_mm=leads[new[str(r.config_id)]] if lead else r.lead_mm) if which(r) else r
            for r in log
        ]

    return spoil


def reverse(names: list[str], rng: np.random.Generator) -> list[str]:
    return names[::-1]


def shuffle(names: list[str], rng: np.random.Generator) -> list[str]:
    half = len(names) // 2
    # far from the right order and from the reverse
    return [names[i] for pair in zip(range(half, len(names)), [*range(half), None], strict=False) for i in pair if i is not None]


def exchange(names: list[str], rng: np.random.Generator) -> list[str]:
    out = list(names)
    out[1], out[-2] = out[-2], out[1]
    return out


def copied(change: Callable[[Run], Run]) -> Callable[[Log, np.random.Generator], Log]:
    return lambda log, rng: [*log, replace(change(log[int(rng.integers(len(log)))]), run_id="second")]


def tail(r: Run) -> Run:
    a, b = len(r) // 5, len(r) * 4 // 5
    kept = {n: v[a:b] for n in ("position_in_mm", "tension_ref_n") if (v := getattr(r, n)) is not None}
    return replace(r, time_s=r.time_s[a:b] - r.time_s[a], tension_in_n=r.tension_in_n[a:b], tension_out_n=r.tension_out_n[a:b], **kept)


def two_rigs(log: Log, rng: np.random.Generator) -> Log:
    """Append the recordings of a rig with other sensors under the same labels."""
    noise = 3.0 * float(np.std(np.diff(log[0].tension_in_n, 2))) / 2.45
    other = []
    for r in log:
        n = rng.standard_normal((2, len(r))) * noise
        other.append(
            replace(r, run_id=f"{r.run_id}-b", tension_in_n=1.05 * r.tension_in_n + n[0], tension_out_n=1.3 * r.tension_out_n + n[1])
        )
    return [*log, *other]


def other_bends(log: Log, rng: np.random.Generator) -> Log:
    """Append another rig's runs under the labels of this one: same bends, more friction."""
    new = draw(int(rng.integers(1 << 30)), 0)
    names = configs(log)
    return [*log, *(replace(r, run_id=f"{r.run_id}-b", config_id=names[0], location="CP", lead_mm=log[0].lead_mm) for r in new)]


def joined(log: Log, rng: np.random.Generator) -> Log:
    """Let the rest of one run come from a recording of another log, from where it stands far away."""
    a = max(log, key=len)
    b = max(draw(int(rng.integers(1 << 30)), 0), key=len)
    n = len(a) // 3
    start = int(np.argmax(np.abs(b.tension_in_n[: len(b) // 2] - a.tension_in_n[n])))
    m = min(len(b) - start, len(a) - n)
    x, y = (np.concatenate((getattr(a, c)[:n], getattr(b, c)[start : start + m])) for c in ("tension_in_n", "tension_out_n"))
    new = Run(a.run_id, a.system, a.time_s[: n + m], x, y, a.config_id, a.location, a.lead_mm, a.trajectory)
    return [new if r.run_id == a.run_id else r for r in log]


def held_from(share: float, until: float) -> Callable[[Run], Run]:
    def change(r: Run) -> Run:
        y = r.tension_out_n.copy()
        a, b = int(share * len(y)), int(until * len(y))
        y[a:b] = y[a]
        return replace(r, tension_out_n=y)

    return change


def foreign_output(log: Log, rng: np.random.Generator) -> Log:
    """Pair the input of one movement with the output of another, from another log."""
    other = [r for r in draw(int(rng.integers(1 << 30)), 0, 2, ("act",)) if r.trajectory != "trapezoid"]
    rich = max(other, key=lambda r: float(np.sum(np.abs(np.diff(r.tension_out_n[:: max(1, len(r) // 200)])))))
    mine = next(r for r in log if r.trajectory == "trapezoid")
    part = rich.tension_out_n[:: max(1, len(rich) // len(mine))]
    n = min(len(mine), len(part))
    return [Run(mine.run_id, mine.system, mine.time_s[:n], mine.tension_in_n[:n], part[:n], mine.config_id, mine.location, mine.lead_mm)]


def noisy(r: Run) -> Run:
    rng = np.random.default_rng(1)
    sd = 4.0 * float(np.median(np.abs(np.diff(r.tension_out_n, 2)))) / 0.6745 / 2.45
    return replace(r, tension_out_n=r.tension_out_n + sd * rng.standard_normal(len(r)))


def act(r: Run) -> bool:
    return r.system == "act"


def sstl(r: Run) -> bool:
    return r.system == "sstl"


def as_system(name: str) -> Callable[[Run], Run]:
    return lambda r: replace(r, system=name)


def exchanged(r: Run) -> Run:
    return replace(r, system="sstl" if r.system == "act" else "act")


LABEL = ("labels", "lead_order")
SLIPS = (
    Slip("counts of 12 bits for both", ("counts",), every(counts(80.0, 80.0, 300.0))),
    Slip("counts of 24 bits, zero far away", ("counts", "magnitude"), every(counts(8391.7, 8391.7, 84213.0))),
    Slip("counts for the output only", ("counts",), every(counts(None, 120.0, 0.0))),
    Slip("counts for the input only", ("counts",), every(counts(95.0, None, 512.0))),
    Slip("counts with decimals (a mean was taken)", ("magnitude",), every(scale(412.3, 398.8, 1200.0, 900.0))),
    Slip("kN for both", ("magnitude",), every(scale(1e-3, 1e-3))),
    Slip("kN for the output", ("gain",), every(scale(1.0, 1e-3))),
    Slip("mN for both", ("magnitude",), every(scale(1e3, 1e3))),
    Slip("mN for the input", ("gain", "magnitude"), every(scale(1e3, 1.0))),
    Slip("gf for both", ("magnitude",), every(scale(1 / GF, 1 / GF))),
    Slip("lbf for the input", ("gain", "reference"), every(scale(1 / LBF, 1.0))),
    Slip("lbf for the output", ("gain",), every(scale(1.0, 1 / LBF))),
    Slip("kgf for the output", ("gain",), every(scale(1.0, 1 / KGF))),
    Slip("lbf for both, reference in N", ("reference",), every(scale(1 / LBF, 1 / LBF))),
    Slip("lbf in one file", ("unit_between_runs", "reference"), one(scale(1 / LBF, 1 / LBF))),
    Slip("kN in one file", ("unit_between_runs", "magnitude", "reference"), one(scale(1e-3, 1e-3))),
    Slip("output negative", ("sign",), every(scale(1.0, -1.0))),
    Slip("input negative", ("sign",), every(scale(-1.0, 1.0))),
    Slip("both negative", ("sign",), every(scale(-1.0, -1.0))),
    Slip("output flipped and zeroed anew", ("sign",), every(scale(1.0, -1.0, 0.0, 45.0))),
    Slip("one run negative", ("sign",), one(scale(1.0, -1.0))),
    Slip("input and output swapped", ("swapped",), every(swap)),
    Slip("swapped in one run", ("swapped",), one(swap)),
    Slip("ms as s", ("time_unit",), every(timed(1e3))),
    Slip("us as s", ("time_unit",), every(timed(1e6))),
    Slip("sample index as time", ("time_unit",), every(lambda r: replace(r, time_s=np.arange(len(r), dtype=float)))),
    Slip("s divided by 1000", ("time_unit",), every(timed(1e-3))),
    Slip("ms in one file", ("rate", "time_unit"), one(timed(1e3))),
    Slip("one file at half the rate", ("rate",), one(timed(2.0))),
    Slip("act and sstl exchanged", ("passes",), every(exchanged)),
    Slip("an act run labelled sstl", ("passes",), one(as_system("sstl"), act)),
    Slip("an sstl run labelled act", ("passes",), one(as_system("act"), sstl)),
    Slip("a sensing loop labelled act", ("passes",), every(as_system("act")), None, ("sstl",)),
    Slip("configurations of sstl reversed", LABEL, relabelled(reverse, sstl, lead=True)),
    Slip("configurations of one movement exchanged", LABEL, relabelled(reverse, lambda r: act(r) and "trapezoid" in r.run_id, lead=True)),
    Slip("files shuffled over seven bends", LABEL, relabelled(shuffle, lead=True), 7),
    Slip("two bends of seven exchanged", LABEL, relabelled(exchange, lead=True), 7),
    Slip("leads typed in reverse", LABEL, relabelled(reverse, lead=True), 7),
    Slip("a run twice", ("duplicate",), copied(lambda r: r)),
    Slip("a run twice under another bend", ("duplicate",), copied(lambda r: replace(r, config_id="CP-999"))),
    Slip("a part of a run once more", ("duplicate",), copied(tail)),
    Slip("a run once more in lbf", ("duplicate",), copied(scale(1 / LBF, 1 / LBF))),
    Slip("two rigs, other sensors", ("odd_run", "duplicate"), two_rigs),
    Slip("two rigs, other friction", ("labels", "odd_run", "rate", "passes", "lead_order"), other_bends),
    Slip("two recordings joined", ("joined",), joined),
    Slip("output of one run 1.6 times", ("odd_run", "gain"), one(scale(1.0, 1.6))),
    Slip("one noisy run", ("odd_run",), one(noisy)),
    Slip("zero of one run 6 N off", ("odd_run", "zero"), one(scale(1.0, 1.0, 0.0, 6.0))),
    Slip("output 0.3 s early", ("lead",), every(shifted(0.3))),
    Slip("output 0.1 s early", ("lead",), every(shifted(0.1))),
    Slip("output 1 s late", ("lead",), every(shifted(-1.0))),
    Slip("output's clock 2 % slow", ("drift",), every(drifting(0.02))),
    Slip("output's clock 1 % fast", ("drift",), every(drifting(-0.01))),
    Slip("output tared under load", ("zero",), every(scale(1.0, 1.0, 0.0, -7.0))),
    Slip("input tared under load", ("zero",), every(scale(1.0, 1.0, -6.0, 0.0))),
    Slip("output 10 N too high", ("zero",), every(scale(1.0, 1.0, 0.0, 10.0))),
    Slip("output stuck for a while", ("stuck",), one(held_from(0.15, 0.75))),
    Slip("output dead from the middle on", ("stuck",), one(held_from(0.3, 1.0))),
    Slip("output constant", ("stuck",), one(lambda r: replace(r, tension_out_n=np.full(len(r), 4.2)))),
    Slip("one column taken twice", ("same_channel",), every(lambda r: replace(r, tension_out_n=r.tension_in_n))),
    Slip("clock taken for the input", ("clock_channel",), every(lambda r: replace(r, tension_in_n=r.time_s))),
    Slip("position in m", ("position",), every(lambda r: replace(r, position_in_mm=None if r.position_in_mm is None else r.position_in_mm / 1e3))),
    Slip("output of another movement", ("unrelated",), foreign_output),
    Slip("command taken for the input", ("noiseless",), every(lambda r: replace(r, tension_in_n=r.tension_ref_n))),
)  # fmt: skip

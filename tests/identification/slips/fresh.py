"""More slips of drawn size, written after the gate was frozen: kinds that were not looked at while its rules were made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slips import wrong as w
from slips.drawn import BOTH, KINDS, Kind, Log, Rng, largest, shifted, span, stuck
from sstl_cli.core.runs import Run


def gain_with_zero(log: Log, rng: Rng) -> Log:
    return w.every(w.scale(1.0, 1.0 / w.LBF, 0.0, float(rng.uniform(-0.01, 0.01)) * span(log)))(log, rng)


def current(log: Log, rng: Rng) -> Log:
    return w.every(w.scale(1.0 / float(rng.uniform(3.5, 9.0)), 1.0))(log, rng)


def percent(log: Log, rng: Rng) -> Log:
    """Put the output in percent of a full scale that is far from 100 N."""
    full = largest(log) * float(rng.uniform(1.3, 2.5))
    factor = 100.0 / full
    return w.every(w.scale(1.0, factor if not 1 / 3.5 < factor < 3.5 else 4.0))(log, rng)


def comma_lost(log: Log, rng: Rng) -> Log:
    return w.every(lambda r: replace(r, tension_in_n=np.round(1e3 * r.tension_in_n), tension_out_n=np.round(1e3 * r.tension_out_n)))(
        log, rng
    )


def glued(log: Log, rng: Rng) -> Log:
    """Let a run go on, from far away, with one of another bend of the same rig."""
    a = next(r for r in log if r.trajectory == "trapezoid")
    b = next(r for r in log if r.trajectory == "trapezoid" and r.system == a.system and r.config_id != a.config_id)
    n = len(a) // 2
    apart = np.abs(b.tension_in_n[: len(b) // 2] - a.tension_in_n[n])
    k = int(np.argmax(apart))
    m = min(len(b) - k, n)
    x, y = (np.concatenate((getattr(a, c)[:n], getattr(b, c)[k : k + m])) for c in ("tension_in_n", "tension_out_n"))
    new = Run(a.run_id, a.system, a.time_s[: n + m], x, y, a.config_id, a.location, a.lead_mm, a.trajectory)
    return [new if r.run_id == a.run_id else r for r in log]


def exported_again(log: Log, rng: Rng) -> Log:
    """Append a run as another program wrote it, with fewer digits."""
    step = 3e-4 * span(log)
    return w.copied(
        lambda r: replace(r, tension_in_n=np.round(r.tension_in_n / step) * step, tension_out_n=np.round(r.tension_out_n / step) * step)
    )(log, rng)


def one_bend_exchanged(log: Log, rng: Rng) -> Log:
    bend = str(rng.choice(w.configs(log)))
    return [w.exchanged(r) if r.config_id == bend else r for r in log]


def one_early(log: Log, rng: Rng) -> Log:
    return w.one(lambda r: shifted(float(rng.uniform(0.02, 0.05)) * float(r.time_s[-1]))(r))(log, rng)


def input_stuck(log: Log, rng: Rng) -> Log:
    def flip(g: Log) -> Log:
        return [w.swap(r) for r in g]

    return flip(stuck(flip(log), rng))


def one_zero(log: Log, rng: Rng) -> Log:
    return w.one(w.scale(1.0, 1.0, 0.0, float(rng.choice([-1.0, 1.0])) * float(rng.uniform(0.25, 0.4)) * span(log)))(log, rng)


FRESH: tuple[Kind, ...] = (
    ("output in lbf, its zero off", ("gain",), gain_with_zero, {}),
    ("motor current taken for the input", ("gain", "reference"), current, {}),
    ("output in percent of full scale", ("gain", "magnitude"), percent, {}),
    ("output reads half", ("gain",), w.every(w.scale(1.0, 0.5)), {}),
    ("decimal comma lost", ("counts", "magnitude"), comma_lost, {"sizes": (3.0, 500.0)}),
    ("gf for the output", ("gain", "magnitude"), w.every(w.scale(1.0, 1.0 / w.GF)), {}),
    ("ns as s", ("time_unit",), w.every(w.timed(1e9)), {}),
    ("us as s in one file", ("rate", "time_unit"), w.one(w.timed(1e6)), {}),
    ("two bends glued into one run", ("joined",), glued, {"leads": 2}),
    ("a run exported once more with fewer digits", ("duplicate",), exported_again, {}),
    ("act and sstl exchanged in one bend", ("passes",), one_bend_exchanged, {"systems": BOTH, "leads": 3}),
    ("output of one run flipped", ("sign",), w.one(w.scale(1.0, -1.0)), {}),
    ("output of one run early", ("lead",), one_early, {}),
    ("input stuck", ("stuck",), input_stuck, {}),
    ("output's zero off in one run", ("zero", "odd_run", "sign"), one_zero, {"leads": 3, "sizes": (25.0, 500.0)}),
)  # fmt: skip
ALL = (*KINDS, *FRESH)

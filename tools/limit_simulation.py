"""Hold predicted error rates against simulated ones: ten cases, many draws of their noise, both models refitted to each.

    python tools/limit_simulation.py [--draws 200] [--out data/limit_simulation.json]

Each effect is made weaker until its nearest rival is at D^2 = 2 to 8, where errors are frequent enough to be counted.
An error is a draw on which the rival is the more likely model, each relieved of what the noise gives it on average where it is the
truth (half a nat a free parameter, less of one that stands at its bound). Predicted is the normal tail of D / 2, and beside it what
the linear responses say where all that is free is refitted to the noise. With the input known that must agree; with full recordings,
smoothed as `diagnose` smooths them, the simulated rate must lie between it and what is predicted for an unsmoothed input, intervals allowed for.
"""

from __future__ import annotations

import argparse
import json
from copy import copy
from dataclasses import dataclass, replace
from math import erf, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from page_part import commit

from sstl_cli.blind import distance
from sstl_cli.blind.cases import rebuild
from sstl_cli.blind.judge import wilson
from sstl_cli.blind.record import Source
from sstl_cli.blind.schedule import Entry, Job
from sstl_cli.core.rng import stream
from sstl_cli.diagnosis.fit import Fit, fit
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.whitening import Whitener, whitener
from sstl_cli.physics.effects import get
from sstl_cli.physics.rig.sensors import sensor_noise
from sstl_cli.steps.blind_make import draw_job

Array = NDArray[np.float64]
TEN = (
    ("gain_error", "rig", 41), ("asymmetric_friction", "rig", 42), ("zero_drift", "bristle", 43), ("const_friction", "rig", 44),
    ("friction_drift", "rig", 45), ("load_dependent_friction", "rig", 46), ("crosstalk", "variant", 47), ("zero_offset", "bristle", 48),
    ("sensor_nonlinearity", "rig", 49), ("channel_delay", "rig", 50),
)  # fmt: skip
TARGETS = (2.0, 4.0, 8.0)
WEAKENED = 5
ROUNDS = 4


@dataclass(frozen=True)
class Case:
    """A case with a weakened effect, and the two models that compete."""

    effect: str
    rival: str
    truth: distance.Truth
    own: Fit
    other: Fit
    d2: float
    d2_known: float


def case_of(effect: str, simulator: str, seed: int, target: float) -> Case:
    """Return the case of an effect that is made weaker until the nearest rival is near the target distance."""
    drawn = draw_job(Job(Entry("single", (effect,), 1.2), seed, simulator, True))
    source, effects = rebuild(drawn.truth)
    for _ in range(WEAKENED):
        truth = distance.truth_of(source, effects, drawn.sim)
        found = distance.follow(truth)
        own = _own(found)
        rival = min(found.rivals, key=lambda r: found.rivals[r].cost)
        d2 = d2_of(found.rivals[rival]) - d2_of(own)
        if d2 < 1.6 * target:
            break
        effects = weaker(effects, sqrt(target / d2))
    known = [settled(truth, own, f) for f in (own, found.rivals[rival])]
    return Case(effect, rival, truth, known[0], known[1], d2, d2_of(known[1]) - d2_of(known[0]))


def weaker(effects: distance.Effects, share: float) -> dict[str, dict[str, float]]:
    """Return effects with their strengths brought nearer to neutral; shapes stay."""
    return {
        e: {
            n: v if get(e).parameter(n).shape else get(e).parameter(n).neutral + share * (v - get(e).parameter(n).neutral)
            for n, v in values.items()
        }
        for e, values in effects.items()
    }


def _own(found: distance.Followed) -> Fit:
    # of an effect that is a candidate there is a fit
    assert found.own is not None
    return found.own


def settled(truth: distance.Truth, phases_of: Fit, f: Fit) -> Fit:
    """Return a model refitted to the noise-free session with the output's noise alone."""
    return fit(truth.sim, truth.whitener(phases_of, True), f.hypothesis, f.theta, f.values, ROUNDS + 2)


def d2_of(f: Fit) -> float:
    """Return the squared distance that a fit leaves."""
    return 2.0 * f.cost - f.whiten.log_det


def known_input(case: Case, draws: int) -> list[bool]:
    """Return for each draw of the output's noise whether the rival came out ahead, the input known."""
    relief, whiten = reliefs(case, draws), case.own.whiten
    return [_rival_ahead(_noisy(case, case.truth.sim.y, k), case, whiten, relief) for k in range(draws)]


def reliefs(case: Case, draws: int) -> tuple[float, float]:
    """Return what noise alone gives either model (nats, mean over draws) where it is the truth, theta and all parameters refitted."""
    mean = []
    for f in (case.own, case.other):
        gained = []
        for k in range(draws):
            noisy = _noisy(case, f.prediction, k)
            z = case.own.whiten(noisy.y - f.prediction)
            done = fit(noisy, case.own.whiten, f.hypothesis, f.theta, f.values, ROUNDS)
            gained.append(0.5 * float(z @ z) + 0.5 * case.own.whiten.log_det - done.cost)
        mean.append(float(np.mean(gained)))
    return mean[0], mean[1]


def _noisy(case: Case, output: Array, k: int) -> Simulator:
    """Return the simulator with an output and the noise of a draw."""
    sim, spec, noise = case.truth.sim, case.truth.source.bench.noise, []
    for r in sim.problem.records:
        rng = stream(k, "limit", case.effect, r.run_id)
        thin = max(1, round(r.dt_s / r.raw.dt_s))
        fine = block_mean(sensor_noise(r.raw.time_s, spec, rng), thin)[: len(r) * r.factor]
        noise.append(block_mean(fine, r.factor))
    noisy = copy(sim)
    noisy.y = output + np.concatenate(noise)
    return noisy


def full_recordings(case: Case, draws: int) -> list[bool]:
    """Return the same for recordings with noise on both sensors, prepared as ``diagnose`` prepares them."""
    truth, source, relief = case.truth, case.truth.source, reliefs(case, draws)
    wrong = []
    for k in range(draws):
        records = prepare([replace(r, position_in_mm=None, tension_ref_n=None) for r in _recorded(source, truth, k)])
        sim = Simulator(records, truth.sim.mechanics, truth.sim.fixed)
        _, noise = truth.noise(True)
        entering = replace(noise, input={s: replace(v, coloured_n=source.bench.noise.coloured_n) for s, v in noise.input.items()})
        whiten = whitener(sim.constants({}, entering), sim.phases(case.own.theta, case.own.effects, entering))
        wrong.append(_rival_ahead(sim, case, whiten, relief))
    return wrong


def _recorded(source: Source, truth: distance.Truth, k: int):
    again = Source(source.bench, source.seed, source._known)
    for run, made in zip(source.bench.runs, source.clean(truth.effects), strict=True):
        rng = stream(k, "limit", "both", run.run_id)
        spec = again.bench.noise
        yield replace(
            made,
            tension_in_n=made.tension_in_n + sensor_noise(made.time_s, spec, rng),
            tension_out_n=made.tension_out_n + sensor_noise(made.time_s, spec, rng),
        )


def _rival_ahead(sim: Simulator, case: Case, whiten, relief: tuple[float, float]) -> bool:
    costs = []
    for f, by_noise in zip((case.own, case.other), relief, strict=True):
        costs.append(fit(sim, whiten, f.hypothesis, f.theta, f.values, ROUNDS).cost + by_noise)
    return bool(costs[1] < costs[0])


def tail(d2: float) -> float:
    """Return the chance that a rival at this distance comes out ahead."""
    return 0.5 * (1.0 - erf(0.5 * sqrt(max(d2, 0.0)) / sqrt(2.0)))


def free_tail(case: Case, draws: int = 20_000) -> float:
    """Return the same where theta and all parameters of both models are refitted to the noise, by their linear responses.

    What two models gain by chance differs, too: by the normal tail alone a rival that shows the very same would come out ahead in
    half of all draws, and with a parameter more, relieved of half a nat for it, does in P(chi^2 > 1) = 32 %.
    """
    whiten = case.own.whiten
    apart = whiten(case.own.prediction - case.other.prediction)
    own, other = (_basis(_columns(f, case.truth.sim, whiten)) for f in (case.own, case.other))
    joint = _basis(np.column_stack((apart, own, other)))
    noise = stream(0, "limit", "free", case.effect).standard_normal((draws, joint.shape[1]))
    seen = noise + joint.T @ apart
    left = [np.sum(v**2, axis=1) - np.sum((v @ (joint.T @ q)) ** 2, axis=1) + q.shape[1] for v, q in ((noise, own), (seen, other))]
    return float(np.mean(left[1] < left[0]))


def _columns(f: Fit, sim: Simulator, whiten: Whitener) -> Array:
    """Return the whitened responses of a model to theta of each configuration and to its parameters, but those at a bound."""
    moves = [min(v - x.parameter.least, x.parameter.most - v) > 1e-6 for x, v in zip(f.free, f.values, strict=True)]
    thetas = np.zeros((len(sim.y), len(f.theta)))
    thetas[np.arange(len(sim.y)), sim.config] = f.jacobian[:, 0]
    return whiten(np.column_stack((thetas, f.jacobian[:, 1:][:, moves])))


def _basis(columns: Array) -> Array:
    """Return an orthonormal basis of the span of columns of any size."""
    scale = np.linalg.norm(columns, axis=0)
    u, s, _ = np.linalg.svd(columns[:, scale > 0.0] / scale[scale > 0.0], full_matrices=False)
    return u[:, s > 1e-6 * s.max(initial=0.0)]


def row(case: Case, draws: int) -> dict:
    """Return predicted and simulated error rates of a case, with Wilson intervals."""
    k, b = sum(known_input(case, draws)), sum(full_recordings(case, draws))
    low, high = wilson(k, draws)
    free = free_tail(case)
    least, most = wilson(b, draws)
    bounds = sorted((tail(case.d2), free))
    return {
        "effect": case.effect, "rival": case.rival, "d2": case.d2, "d2_known": case.d2_known,
        "simulator": case.truth.source.bench.hardware, "draws": draws,
        "predicted_known": tail(case.d2_known), "simulated_known": k / draws, "low": low, "high": high,
        "agrees": low <= tail(case.d2_known) <= high, "predicted_free": free, "agrees_free": low <= free <= high,
        "predicted": tail(case.d2), "simulated_full": b / draws, "full_low": least, "full_high": most,
        "between": most >= bounds[0] and least <= bounds[1],
    }  # fmt: skip


def main() -> None:
    """Write the ten rows, resuming where an earlier run stopped."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--out", type=Path, default=Path("data/limit_simulation.json"))
    given = parser.parse_args()
    np.seterr(all="ignore")
    rows = json.loads(given.out.read_text()) if given.out.exists() else []
    done = {(r["effect"], r["draws"]) for r in rows}
    for i, (effect, simulator, seed) in enumerate(TEN):
        if (effect, given.draws) in done:
            continue
        rows.append({"commit": commit(), **row(case_of(effect, simulator, seed, TARGETS[i % 3]), given.draws)})
        print({k: round(v, 3) if isinstance(v, float) else v for k, v in rows[-1].items()}, flush=True)
        given.out.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()

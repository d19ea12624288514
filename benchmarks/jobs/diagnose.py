"""A whole diagnosis: which of all effects explains the gap."""

from __future__ import annotations

import io
import time
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import Any

import lmfit
import numpy as np

from benchmarks.harness import Row, faster, seconds
from benchmarks.peers import mujoco_fit
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.free import free_parameters
from sstl_cli.diagnosis.question import candidates
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps import diagnose
from sstl_cli.steps import simulate as step

NODES = 10
EFFECT = {"pulley_friction": {"m_p": 0.08, "m_r": 0.06}}


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare with one fit by MuJoCo, and with lmfit driving the same compiled model."""
    rate, repeat, tried = (20.0, 1, 2) if quick else (76.0, 2, 5)
    runs = list(step.run(load("default").model_copy(update={"sampling_hz": rate}), EFFECT, 1))
    samples = sum(len(r) for r in runs)
    options = diagnose.DiagnoseOptions()
    ids = candidates(options)
    found: list[Any] = []

    def ours() -> None:
        found[:] = [diagnose.run(runs, options).document()]

    ours()
    assert "pulley_friction" in found[0]["verdict"]["ambiguity_group"], found[0]["verdict"]
    recorded = 2000 if quick else 15_000
    single, chain = mujoco_fit.Fit(recorded), mujoco_fit.Fit(recorded, NODES)
    fitted: dict[str, float] = {}
    problem = prepare(runs, 1.0)
    simulator = Simulator(problem, Scenario().rig.mechanics(), {})
    able = [i for i in ids if get(i).fitted and get(i).channel == "out"]
    part = able[:: max(1, len(able) // tried)][:tried]
    own, mujoco, chained, library = [], [], [], []
    for _ in range(repeat):
        own.append(seconds(ours))
        with redirect_stdout(io.StringIO()):
            mujoco.append(seconds(lambda: fitted.update(single.run())))
            chained.append(seconds(chain.run))
        library.append(seconds(lambda: [_lmfit(simulator, i) for i in part]))
    off = max(abs(fitted[k] / v - 1.0) for k, v in mujoco_fit.TRUE.items())
    scaled = len(able) / len(part)
    job = f"diagnose, {len(ids)} candidates, {samples} samples"
    return [
        Row(
            "diagnose/chain",
            job,
            f"one sysid fit in MuJoCo, 3 parameters, {recorded} samples, {NODES} nodes along the tendon",
            1.0,
            faster(own, chained),
            seconds={"ours": min(own), "peer": min(chained)},
        ),
        Row(
            "diagnose/mujoco",
            job,
            "the same fit of a single body, which has no line to lose tension along",
            1.0,
            faster(own, mujoco),
            seconds={"ours": min(own), "peer": min(mujoco)},
            note=f"MuJoCo's parameters are off by up to {100 * off:.2g} %",
        ),
        Row(
            "diagnose/lmfit",
            job,
            "lmfit fitting the same compiled model, one candidate after the other",
            20.0,
            faster(own, library, scaled),
            seconds={"ours": min(own), "peer": min(library) * scaled},
            note=f"peer on {len(part)} of {len(able)} candidates, scaled; it fits once, without held-out runs or pairs",
        ),
        *_clock(runs, samples, quick),
        *_exponents(quick),
    ]


def _clock(runs: Sequence[Run], samples: int, quick: bool) -> list[Row]:
    """Return how long a user waits on two cores, and how much longer for ten times the runs."""
    options = diagnose.DiagnoseOptions(workers=2)
    times = 2 if quick else 10
    many = [replace(r, run_id=f"{i} {r.run_id}", config_id=f"{i} {r.config_id}") for i in range(times) for r in runs]
    wall, spent = [], []
    for _ in range(1 if quick else 2):
        began = time.perf_counter()
        spent.append(seconds(lambda: diagnose.run(runs, options)))
        wall.append(time.perf_counter() - began)
    long = seconds(lambda: diagnose.run(many, options))
    return [
        Row(
            "diagnose/clock",
            f"diagnose, {samples} samples",
            "wall time with two threads",
            5.0,
            tuple(wall),
            at_least=False,
            unit="s",
            seconds={"processor": min(spent)},
        ),
        Row(
            "diagnose/tenfold",
            f"diagnose, {times * samples} samples, {len(many)} runs",
            f"time over that of {samples}",
            float(times),
            (long / min(spent),),
            at_least=False,
            unit="(ratio)",
            seconds={"long": long, "short": min(spent)},
        ),
    ]


def _exponents(quick: bool) -> list[Row]:
    """Return how the time grows with samples in a run, with runs, and with candidates."""
    sizes = (1, 2) if quick else (1, 2, 4)
    able = [i for i in candidates(diagnose.DiagnoseOptions()) if get(i).fitted and get(i).channel == "out"]
    rows = []
    for what, goal, jobs in (
        ("samples", 1.05, [(_recorded(k, 1), tuple(able)) for k in sizes]),
        ("runs", 1.05, [(_recorded(1, k), tuple(able)) for k in sizes]),
        # every so many of them, for some take longer than others
        ("candidates", 1.05, [(_recorded(1, 2), tuple(able[::k])) for k in reversed(sizes)]),
    ):
        size = [len(chosen) if what == "candidates" else sum(len(r) for r in runs) for runs, chosen in jobs]
        tries = []
        for _ in range(1 if quick else 2):
            spent = [seconds(lambda j=job: diagnose.run(j[0], diagnose.DiagnoseOptions(effects=j[1]))) for job in jobs]
            tries.append(spent)
        slopes = tuple(float(np.polyfit(np.log(size), np.log(t), 1)[0]) for t in tries)
        rows.append(
            Row(
                f"diagnose/{what}",
                f"diagnose, time over {what}",
                "exponent of the fit",
                goal,
                slopes,
                at_least=False,
                unit="(exponent)",
                seconds={str(n): min(t) for n, t in zip(size, zip(*tries, strict=True), strict=True)},
            )
        )
    return rows


def _recorded(longer: int, more: int) -> list[Run]:
    """Return runs with so many times the loops in each, and so many times as many tubes."""
    scene = load("default")
    paths = tuple(
        t.model_copy(update={"duration_s": longer * t.duration_s, "cycles": longer}) for t in scene.trajectories if t.kind == "trapezoid"
    )
    tubes = tuple(
        c.model_copy(update={"id": f"{c.id}-{i}", "theta": c.theta * (1.0 + 0.02 * i)})
        for i in range(more)
        for c in scene.configurations[:2]
    )
    return list(step.run(scene.model_copy(update={"sampling_hz": 76.0, "trajectories": paths, "configurations": tubes}), EFFECT, 1))


def _lmfit(simulator: Simulator, effect_id: str) -> Any:
    """Fit theta of every configuration and the parameters of one effect by least squares."""
    configs = len(simulator.problem.configs)
    free = free_parameters([effect_id], ["act", "sstl"])
    unknown = lmfit.Parameters()
    for i in range(configs):
        unknown.add(f"theta_{i}", 0.53, min=0.05, max=1.5)
    for f in free:
        # a quarter of the range: at the neutral value many effects have no derivative
        unknown.add(f"{f.effect.id}__{f.parameter.name}", f.parameter.low + 0.25 * f.width, min=f.parameter.low, max=f.parameter.high)

    def residual(values: Any) -> np.ndarray:
        effects: dict[str, dict[str, float]] = {}
        for f in free:
            effects.setdefault(f.effect.id, {})[f.parameter.name] = float(values[f"{f.effect.id}__{f.parameter.name}"])
        theta = np.array([float(values[f"theta_{i}"]) for i in range(configs)])
        return simulator.predict(theta, effects) - simulator.y

    return lmfit.minimize(residual, unknown, method="leastsq", max_nfev=300)

"""A whole diagnosis: which of all effects explains the gap."""

from __future__ import annotations

import io
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import lmfit
import numpy as np

from benchmarks.harness import Row, faster, seconds
from benchmarks.peers import mujoco_fit
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator, free_parameters
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
    ids = diagnose.candidates(options, [])
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
        Row("diagnose/chain", job, f"one sysid fit in MuJoCo, 3 parameters, {recorded} samples, {NODES} nodes along the tendon",
            1.0, faster(own, chained), seconds={"ours": min(own), "peer": min(chained)}),
        Row("diagnose/mujoco", job, "the same fit of a single body, which has no line to lose tension along", 1.0,
            faster(own, mujoco), seconds={"ours": min(own), "peer": min(mujoco)},
            note=f"MuJoCo's parameters are off by up to {100 * off:.2g} %"),
        Row("diagnose/lmfit", job, "lmfit fitting the same compiled model, one candidate after the other", 20.0,
            faster(own, library, scaled), seconds={"ours": min(own), "peer": min(library) * scaled},
            note=f"peer on {len(part)} of {len(able)} candidates, scaled; it fits once, without held-out runs or pairs"),
    ]


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

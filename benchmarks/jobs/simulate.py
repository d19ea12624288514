"""The fast model: one sample after the other, and a whole log with its file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.harness import Row, faster, paired
from benchmarks.peers import mujoco_tendon, play_plain
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import write_runs
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.scenario import Configuration, Scenario, Trajectory
from sstl_cli.physics.transmission import predict
from sstl_cli.physics.transmission.model import activate, drive_of
from sstl_cli.steps import simulate as step

THETA = 0.53


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare the recursion with Python and MuJoCo, and the simulated log with writing its file."""
    samples, repeat = (20_000, 2) if quick else (600_000, 7)
    path = 15.0 - 10.0 * np.cos(np.arange(samples) * 2.0 * np.pi / 6000.0)
    drive = drive_of("act", "CP", 0.002, path, Mechanics())
    active = activate({})
    listed = path.tolist()
    gammas = float(np.exp(-THETA)), float(np.exp(THETA))

    def ours() -> object:
        return predict(drive, THETA, active, float(path[0]))

    def plain() -> list[float]:
        return play_plain.play(listed, *gammas, listed[0])

    assert np.allclose(np.asarray(ours()), plain(), rtol=1e-12)
    tendon = mujoco_tendon.Tendon(mujoco_tendon.xml(0.002))
    tenth = path[: samples // 10]

    own, python = paired(ours, plain, repeat)
    own_too, mujoco = paired(ours, lambda: tendon.step(tenth), repeat)
    job = f"simulate (fast model), {samples} samples"
    rows = [
        Row(
            "simulate/python",
            job,
            "the same recursion in plain Python",
            100.0,
            faster(own, python),
            seconds={"ours": min(own), "peer": min(python)},
        ),
        Row(
            "simulate/mujoco",
            job,
            "MuJoCo stepping a tendon with friction loss (its compiled rollout)",
            20.0,
            faster(own_too, mujoco, 10.0),
            seconds={"ours": min(own_too), "peer": 10.0 * min(mujoco)},
            note="peer on a tenth of the samples, scaled",
        ),
    ]
    return [*rows, _file(quick, folder, 2 if quick else 5)]


def _file(quick: bool, folder: Path, repeat: int) -> Row:
    count, duration = (2, 20.0) if quick else (20, 120.0)
    scenario = Scenario(
        configurations=tuple(Configuration(id=f"CP-{i:03d}", location="CP", theta=0.4 + 0.01 * i) for i in range(count)),
        trajectories=(Trajectory(kind="trapezoid", duration_s=duration),),
    )
    kept = list(step.run(scenario, {}, 1))
    note = Provenance("benchmark", 1, [])

    def ours() -> None:
        write_runs(folder / "ours.parquet", step.run(scenario, {}, 1), note, force=True)

    def writing() -> None:
        write_runs(folder / "peer.parquet", kept, note, force=True)

    own, peer = paired(ours, writing, repeat)
    samples = sum(len(r) for r in kept)
    return Row(
        "simulate/writing",
        f"simulate {len(kept)} runs, {samples} samples, to Parquet",
        "time of writing the Parquet alone",
        3.0,
        faster(peer, own),
        at_least=False,
        seconds={"ours": min(own), "peer": min(peer)},
    )

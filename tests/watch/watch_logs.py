"""Recordings for the tests of watch: loops of the rig, which shares no code with what is tested."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sstl_cli.physics.rig import NoiseSpec, RigRun, RigSpec, simulate_rig

HEAD = "run_id,config_id,system,time_s,tension_in_n,tension_out_n\n"
HZ, PERIOD_S = 50.0, 6.0


def loops(count: int, effects: dict, seed: int, theta: float = 0.53, system: str = "act", start_s: float = 0.0):
    """Time (s), input and output tension (N) of loops between 2 and 20 N (SSTL: 0.5 and 40 N)."""
    low, high = (2.0, 20.0) if system == "act" else (0.5, 40.0)
    time = np.arange(int(count * PERIOD_S * HZ)) / HZ
    command = np.interp(time % PERIOD_S, [0, 2.7, 3.0, 5.7, PERIOD_S], [low, high, high, low, low])
    run = RigRun(system, theta, "CP", time, "tension", command)
    found = simulate_rig(RigSpec(nodes=15), run, effects, NoiseSpec(0.02, 0.0), seed)
    return time + start_s, found.tension_in_n, found.tension_out_n


def lines(parts, system: str = "act", config: str = "A", run: str = "r1") -> list[str]:
    """The rows of a CSV log."""
    return [f"{run},{config},{system},{t:.4f},{a:.5f},{b:.5f}\n" for part in parts for t, a, b in zip(*part, strict=True)]


def write(path: Path, rows: list[str]) -> Path:
    path.write_text(HEAD + "".join(rows))
    return path

"""Recordings of a rig with two actuation tendons and one sensing loop, put together by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sstl_cli.core.runs import Run
from sstl_cli.physics.rig import NoiseSpec, RigRun, RigSpec, simulate_rig

SPEC = RigSpec(nodes=15)
HZ = 50.0
MOVES = {"steps": [3, 26, 26, 4, 4, 15, 8, 22, 3], "ramps": [2, 12, 6, 30, 30, 2, 20, 20, 2]}


def command(name: str, seconds: float = 40.0, shift_s: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Time (s) and input tension (N) of a movement; a shift lets another tendon do the same later."""
    time = np.arange(int(seconds * HZ)) / HZ
    knots = np.linspace(0.0, seconds, len(MOVES[name]))
    return time, np.interp(np.clip(time - shift_s, 0.0, None), knots, MOVES[name])


def act(tendon: str, config: str, theta: float, move: str, effects: dict, seed: int, shift_s: float = 0.0, neighbour=None) -> Run:
    time, path = command(move, shift_s=shift_s)
    run = RigRun("act", theta, "CP", time, "tension", path, neighbour)
    found = simulate_rig(SPEC, run, effects, NoiseSpec(0.02, 0.0), seed)
    return Run(
        f"{config}-{move}-{tendon}",
        "act",
        found.time_s,
        found.tension_in_n,
        found.tension_out_n,
        config_id=config,
        trajectory=move,
        tendon=tendon,
    )


def sstl(config: str, theta: float, move: str, effects: dict, seed: int) -> Run:
    time, path = command(move)
    found = simulate_rig(SPEC, RigRun("sstl", theta, "CP", time, "tension", path), effects, NoiseSpec(0.02, 0.0), seed)
    return Run(f"{config}-{move}-loop", "sstl", found.time_s, found.tension_in_n, found.tension_out_n, config_id=config, trajectory=move)


def log(effects_a: dict, effects_b: dict) -> list[Run]:
    """Two configurations, two movements, tendons A and B (which pulls 7 s later), one sensing loop."""
    runs = []
    for k, (config, theta) in enumerate((("c1", 0.46), ("c2", 0.60))):
        for m, move in enumerate(MOVES):
            seed = 100 * k + 10 * m
            first, later = command(move)[1], command(move, shift_s=7.0)[1]
            runs.append(act("A", config, theta, move, effects_a, seed, neighbour=later))
            runs.append(act("B", config, theta, move, effects_b, seed + 1, 7.0, neighbour=first))
            runs.append(sstl(config, theta, move, {}, seed + 2))
    return runs


def without_tendons(runs: list[Run]) -> list[Run]:
    return [replace(r, tendon=None) for r in runs if r.tendon != "B"]

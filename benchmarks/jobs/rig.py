"""The rig's own solver against scipy's, on the same chain."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.harness import Row, faster, paired
from benchmarks.peers import chain_ivp
from sstl_cli.physics.rig import QUIET, RigRun, RigSpec, bend_weights, simulate_rig

THETA = 0.53
RATE_HZ = 200.0


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare both with the capstan solution refined in time; scipy is given the larger error."""
    spec = RigSpec()
    duration, repeat = 2.0, 1 if quick else 3
    time = np.arange(round(duration * RATE_HZ)) / RATE_HZ
    path = 15.0 - 10.0 * np.cos(2.0 * np.pi * time / duration)
    rig_run = RigRun("act", THETA, "CP", time, "tension", path)

    def ours() -> np.ndarray:
        return simulate_rig(spec, rig_run, noise=QUIET).true_tension_out_n

    angle = THETA * bend_weights(spec, "act", "CP")
    half = 2.0 * np.tanh(0.5 * angle)
    per_node = spec.length_mm / spec.ea_n / spec.nodes
    springs = np.full(spec.nodes + 1, per_node)
    springs[[0, -1]] *= 0.5
    chain = chain_ivp.Chain(springs, spec.load_k1_n_per_mm, half, half, spec.pretension_n)

    fine_time = np.linspace(0.0, time[-1], 16 * (len(time) - 1) + 1)
    fine = RigRun("act", THETA, "CP", fine_time, "tension", np.interp(fine_time, time, path))
    truth = simulate_rig(spec, fine, noise=QUIET).true_tension_out_n[::16]
    peer_error = float(np.sqrt(np.mean((chain_ivp.march(chain, time, path) - truth) ** 2)))
    own_error = float(np.sqrt(np.mean((ours() - truth) ** 2)))
    # else the comparison would not be at equal accuracy (or not of the same chain)
    assert own_error <= peer_error < 0.1, (own_error, peer_error)
    own, peer = paired(lambda: [ours() for _ in range(20)], lambda: chain_ivp.march(chain, time, path), repeat)
    note = f"RMS error {1e3 * own_error:.2g} mN, solve_ivp {1e3 * peer_error:.2g} mN"
    return [
        Row(
            "rig/solve_ivp",
            f"rig, {spec.nodes} nodes, {len(time)} samples",
            "scipy solve_ivp (LSODA, banded), same chain",
            50.0,
            faster(own, peer, 20.0),
            seconds={"ours": min(own) / 20.0, "peer": min(peer)},
            note=note,
        )
    ]

"""The controller over a recorded input tension."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.harness import Row, faster, paired
from benchmarks.peers import controller_plain
from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.references import random

TABLE_II = (0.583, -1.444, 1.688, -1.043)


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare with the same controller in plain Python."""
    duration, repeat = (40.0, 2) if quick else (800.0, 7)
    reference = random(np.random.default_rng(1), duration_s=duration).tension_n
    controller = Controller(Theta(*TABLE_II), Options())
    # recorded behind a lag of 40 ms, as a tension loop would
    wish = (reference - TABLE_II[1]) / TABLE_II[0]
    recorded = np.convolve(np.concatenate((np.full(19, wish[0]), wish)), np.full(20, 0.05), "valid")
    lists = reference.tolist(), recorded.tolist()

    def ours() -> np.ndarray:
        controller.reset()
        return controller.replay(reference, recorded)[0]

    def plain() -> tuple[list[float], list[str]]:
        return controller_plain.replay(TABLE_II, *lists)

    assert np.allclose(ours(), plain()[0], atol=1e-9), "both must be the same controller"
    own, peer = paired(ours, plain, repeat)
    return [
        Row(
            "compensate/python",
            f"compensate offline, {len(reference)} samples",
            "the same controller in plain Python",
            100.0,
            faster(own, peer),
            seconds={"ours": min(own), "peer": min(peer)},
        )
    ]

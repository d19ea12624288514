"""Theta of 200 runs of 60 000 samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from scipy.signal import butter, filtfilt

from benchmarks import logs
from benchmarks.harness import Row, faster, seconds
from benchmarks.peers import segment_plain
from sstl_cli.cli.segment import UNUSED
from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.core.runs import read_runs
from sstl_cli.identification import SegmentOptions
from sstl_cli.steps import segment as step


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare with the plain procedure, and with reading and filtering alone."""
    runs, samples, part, repeat = (4, 20_000, 2, 2) if quick else (200, 60_000, 4, 3)
    whole = logs.write(folder / "whole.parquet", runs, samples)
    few = logs.write(folder / "few.parquet", part, samples)

    def ours() -> list[ThetaRow]:
        return [found.row() for found in step.run(read_runs(whole, UNUSED), SegmentOptions())]

    def plain() -> object:
        return segment_plain.theta(few)

    def filtering() -> None:
        b, a = butter(2, 10.0, fs=logs.RATE_HZ)
        table = pq.read_table(whole)
        for name in ("tension_in_n", "tension_out_n"):
            for signal in table[name].to_numpy().reshape(runs, samples):
                filtfilt(b, a, signal)

    truth = dict(zip(("gamma_p", "beta_p", "gamma_r", "beta_r"), logs.TRUTH, strict=True))
    rows, theirs = ours(), segment_plain.theta(few)
    for name, value in truth.items():
        # a comparison of two wrong answers would say nothing
        assert all(abs(getattr(r, name) - value) < 0.05 for r in rows), name
        assert np.all(np.abs(theirs[name] - value) < 0.2), name
    own, peer, base = [], [], []
    for _ in range(repeat):
        own.append(seconds(ours))
        peer.append(seconds(plain))
        base.append(seconds(filtering))
    job = f"segment {runs} runs x {samples} samples"
    note = f"peer on {part} runs, scaled by {runs / part:g}"
    return [
        Row(
            "segment/plain",
            job,
            "pandas, filtfilt, RANSACRegressor per loop",
            15.0,
            faster(own, peer, runs / part),
            seconds={"ours": min(own), "peer": min(peer) * runs / part},
            note=note,
        ),
        Row(
            "segment/filtering",
            job,
            "time of reading the Parquet and filtering two channels once",
            2.5,
            faster(base, own),
            at_least=False,
            seconds={"ours": min(own), "peer": min(base)},
        ),
    ]

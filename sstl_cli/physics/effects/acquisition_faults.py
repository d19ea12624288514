"""Recorder faults: spikes, dropouts, frozen samples and clock jitter."""

import numpy as np

from sstl_cli.physics.effect import INSTRUMENT, Array, Effect, Parameter, Sampling, Values

FROZEN_S = 0.05


def _faulty(tension: Array, _other: Array, run: Sampling, v: Values) -> Array:
    if run.rng is None:
        return tension
    out, n, rng = tension.copy(), len(tension), run.rng
    if v["jitter_pct"] > 0.0:
        # a late clock reads the signal a fraction of a period off
        at = np.arange(n) + v["jitter_pct"] / 100.0 * 10.0 * rng.standard_normal(n)
        out = np.interp(at, np.arange(n), out)
    if v["frozen_pct"] > 0.0:
        length = max(2, round(FROZEN_S / run.dt_s))
        starts = np.flatnonzero(rng.random(n) < v["frozen_pct"] / 100.0 / length)
        for start in starts:
            out[start : start + length] = out[start]
    if v["dropout_pct"] > 0.0:
        out[rng.random(n) < v["dropout_pct"] / 100.0] = 0.0
    if v["spike_pct"] > 0.0:
        hit = rng.random(n) < v["spike_pct"] / 100.0
        out[hit] += v["spike_n"] * np.where(rng.random(int(hit.sum())) < 0.5, -1.0, 1.0)
    return out


EFFECT = Effect(
    id="acquisition_faults",
    title="Faults of the recorder",
    stage=INSTRUMENT,
    equation="single samples replaced: T + spike, 0, or the sample before",
    source="Catalogue entry [T]",
    parameters=(
        Parameter("spike_pct", "%", 0.0, 0.0, 2.0, "share of samples with a spike"),
        Parameter("spike_n", "N", 5.0, 0.5, 50.0, "height of a spike", shape=True),
        Parameter("dropout_pct", "%", 0.0, 0.0, 2.0, "share of samples dropped to zero"),
        Parameter("frozen_pct", "%", 0.0, 0.0, 2.0, "share of samples that repeat the one before"),
        Parameter("jitter_pct", "%", 0.0, 0.0, 2.0, "clock jitter, in tenths of a sampling period per percent"),
    ),
    excitation="Any record, before filtering.",
    order=95,
    fitted=False,
    output=_faulty,
    input=_faulty,
)

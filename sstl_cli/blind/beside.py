"""Distances in the channels beside the output: the position, and the input against its reference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.blind.distance import Apart, Truth, truth_of
from sstl_cli.diagnosis import channels
from sstl_cli.diagnosis.channels import ChannelGap
from sstl_cli.diagnosis.fit import first_theta, fit
from sstl_cli.diagnosis.found import NOTHING
from sstl_cli.diagnosis.laid import constants
from sstl_cli.diagnosis.latent import block_mean
from sstl_cli.diagnosis.whitening import Noise, Phases, white, whitener
from sstl_cli.physics.effects import catalogue
from sstl_cli.physics.filters import first_order

Array = NDArray[np.float64]


def position(truth: Truth) -> Apart:
    """Return the distances of a case in the recorded position, origin and stiffness of the load free.

    The noise of the position is white, and that of the tensions enters it far below: both ends of the input noise are one.
    """
    gaps = _position_gaps(truth)
    law, left = _position_gaps(truth_of(truth.source, {}, truth.claimed)), {g.effect: _position_d2(truth, g.rmse_with) for g in gaps}
    base, bare = _position_d2(truth, gaps[0].rmse_base), _position_d2(truth, law[0].rmse_base)
    own = left.pop(next(iter(truth.effects)), None)
    rivals = {k: max(v - (bare if own is None else own), 0.0) for k, v in left.items()}
    beyond = max(base - bare, 0.0)
    return Apart(beyond, beyond, rivals, rivals, bare, own)


def _position_gaps(truth: Truth) -> list[ChannelGap]:
    sim = truth.sim
    plain = white(1.0, sim.weight, [s.start for s in sim.slices()])
    theta = np.array([truth.source.bench.theta[int(c[1:]) - 1] for c in sim.problem.configs])
    base = fit(sim, plain, NOTHING, first_theta(sim, theta), np.zeros(0))
    claimed = truth.claimed.effects
    free = [e for e in catalogue() if e not in claimed]
    return channels.position_gaps(replace(sim, fixed=claimed), base, free)


def _position_d2(truth: Truth, rms_mm: float) -> float:
    samples = sum(len(r.raw) for r in truth.sim.problem.records)
    return float(samples * (rms_mm / truth.source.bench.noise.position_mm) ** 2)


def loop(truth: Truth) -> Apart:
    """Return the distances of a case between the input and its reference; no other effect is a candidate there."""
    found = channels.loop_gaps(truth.sim.problem.records)
    base = _loop_d2(truth, {})
    own = _loop_d2(truth, found[0].values) if found else base
    beyond = max(base - own, 0.0)
    return Apart(beyond, beyond, {}, {}, own, own)


def _loop_d2(truth: Truth, values: dict[str, float]) -> float:
    records, noise = truth.noise(False)
    parts = []
    for r in records:
        reference = np.asarray(r.raw.tension_ref_n)
        lagged = first_order(reference, r.raw.dt_s, values["tau_s"], values["inverse_slew_s_per_n"]) if values else reference
        parts.append(block_mean(block_mean(r.raw.tension_in_n - lagged, r.thin)[: len(r) * r.factor], r.factor))
    still = np.zeros(sum(len(p) for p in parts))
    # nothing slides between two readings of one tension: the noise of the input sensor stands alone
    alone = Noise(noise.input, noise.input, noise.smoother)
    z = whitener(constants(records, alone), Phases(still, still, still, still))(np.concatenate(parts))
    return float(z @ z)

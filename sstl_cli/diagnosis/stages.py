"""Which stage of a controller makes its tracking error: Shapley values over stages replaced by the truth.

Stages of a command stream: mapping (slopes), bias, backlash handling, loop lag, plant (what the
propagation lines do not describe). Each subset of stages is set right and the run simulated again; a
stage's share is its mean contribution over all orders (Shapley 1953), so the shares add to the whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop, track
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import LAG_LONGEST_S, LAG_POINTS, LAG_ROUNDS, LEAST_SAMPLES, MIN_STREAM
from sstl_cli.identification import segment_run
from sstl_cli.physics.filters import first_order

Array = NDArray[np.float64]
STAGES = ("mapping", "bias", "backlash handling", "loop lag", "plant")


@dataclass(frozen=True)
class Stream:
    """A recorded command stream: reference, command, input and output tension (N), phase labels, shape (n,)."""

    run_id: str
    time_s: Array
    reference_n: Array
    command_n: Array
    input_n: Array
    output_n: Array
    phase: NDArray[np.str_]


@dataclass(frozen=True)
class StageShares:
    """Tracking RMSE (N) and the share of its square that each stage makes (sums to 100)."""

    run_id: str
    rmse_n: float
    simulated_rmse_n: float
    share_pct: dict[str, float]
    believed: Theta
    true: Theta
    loop_tau_s: float


def stage_shares(stream: Stream) -> StageShares:
    """Return which stages make the tracking error of a command stream.

    Raises
    ------
    SstlError
        If the stream has too few samples, or shows too little propagation to tell belief from truth.
    """
    if len(stream.time_s) < MIN_STREAM:
        raise SstlError(f"fewer than {MIN_STREAM} samples", where=f"run {stream.run_id!r}", code="E930")
    dt = float(np.median(np.diff(stream.time_s)))
    believed, true = _believed(stream), _true(stream)
    tau = _loop_lag(stream, dt)
    residual = stream.output_n - PlayTendon(true)(stream.input_n, dt)

    def error2(right: frozenset[str]) -> float:
        gp, gr = (true.gamma_p, true.gamma_r) if "mapping" in right else (believed.gamma_p, believed.gamma_r)
        bp, br = (true.beta_p, true.beta_r) if "bias" in right else (believed.beta_p, believed.beta_r)
        reversal = "play" if "backlash handling" in right else "paper"
        controller = Controller(Theta(gp, bp, max(gr, gp), br), Options(dt_s=dt, reversal=reversal))
        plant = Plant(PlayTendon(true), TensionLoop(0.0 if "loop lag" in right else tau))
        out = track(controller, plant, stream.reference_n).tension_out
        if "plant" not in right:
            out = out + residual
        return float(np.mean((stream.reference_n - out) ** 2))

    values: dict[frozenset[str], float] = {frozenset(): error2(frozenset())}
    n = len(STAGES)
    for mask in range(1, 2**n):
        subset = frozenset(s for i, s in enumerate(STAGES) if mask >> i & 1)
        values[subset] = error2(subset)
    shares = {}
    for stage in STAGES:
        total = 0.0
        for subset in (s for s in values if stage not in s):
            weight = factorial(len(subset)) * factorial(n - len(subset) - 1) / factorial(n)
            total += weight * (values[subset] - values[subset | {stage}])
        shares[stage] = total
    made = sum(shares.values())
    percent = {k: 100.0 * v / made if abs(made) > 1e-15 else 0.0 for k, v in shares.items()}
    actual = float(np.sqrt(np.mean((stream.reference_n - stream.output_n) ** 2)))
    return StageShares(stream.run_id, actual, float(np.sqrt(values[frozenset()])), percent, believed, true, tau)


def _believed(stream: Stream) -> Theta:
    """Return the lines that the commands were computed from: in propagation T_ref = Gamma T_cmd + beta, Eq. (ff_cmd)."""
    lines = []
    for phase in ("PP", "RP"):
        chosen = stream.phase == phase
        if chosen.sum() < LEAST_SAMPLES or np.ptp(stream.command_n[chosen]) < 1e-6:
            raise SstlError(f"no {phase} samples in the command stream", where=f"run {stream.run_id!r}", code="E931")
        lines += [float(v) for v in np.polyfit(stream.command_n[chosen], stream.reference_n[chosen], 1)]
    return Theta(*lines)


def _true(stream: Stream) -> Theta:
    found = segment_run(Run(stream.run_id, "act", stream.time_s, stream.input_n, stream.output_n))
    theta = found.theta
    lines = [theta[k] for k in ("gamma_p", "beta_p", "gamma_r", "beta_r")]
    known = [v for v in lines if v is not None]
    if len(known) < len(lines):
        raise SstlError(f"propagation lines of the plant: {found.status}", where=f"run {stream.run_id!r}", code="E932")
    return Theta(*known)


def _loop_lag(stream: Stream, dt: float) -> float:
    """Return the time constant (s) with which the input follows its command, from a grid refined twice."""
    low, high = 0.0, LAG_LONGEST_S
    best = 0.0
    for _ in range(LAG_ROUNDS):
        grid = np.linspace(low, high, LAG_POINTS)
        errors = [float(np.mean((first_order(stream.command_n, dt, t) - stream.input_n) ** 2)) for t in grid]
        best = float(grid[int(np.argmin(errors))])
        width = (high - low) / (LAG_POINTS - 1)
        low, high = max(best - width, 0.0), best + width
    return best

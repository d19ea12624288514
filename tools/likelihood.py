"""Is the likelihood right? Whitened residuals of recordings in which nothing is missing, by simulator and phase.

Usage: python tools/likelihood.py [--cases 20] [--seed 515] [--out docs/likelihood.md]
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sstl_cli.blind.cases import draw
from sstl_cli.blind.schedule import Entry
from sstl_cli.blind.simulators import NAMES
from sstl_cli.core.files import atomic
from sstl_cli.diagnosis import noise
from sstl_cli.diagnosis.fit import first_theta, fit, settle
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.search import NOTHING
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.where import PHASES, phases
from sstl_cli.diagnosis.whitening import white

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Checked:
    """One null: chi^2 per sample by phase, samples by phase, and the correlation of neighbours."""

    chi2: Array
    samples: Array
    lag_one: float


def check(simulator: str, seed: int) -> Checked:
    """Return what the base leaves of a null of one simulator, whitened by the noise estimated from it."""
    case = draw(Entry("none"), seed, True, simulator)
    problem = prepare(case.runs)
    sim = Simulator(problem, case.sim.rig.mechanics())
    plain = white(1.0, sim.weight, [s.start for s in sim.slices()])
    nominal = np.array([case.sim.theta_of(c) for c in problem.configs])
    base = fit(sim, plain, NOTHING, first_theta(sim, nominal), np.zeros(0))
    seen = sim.phases(base.theta, {})
    own = (sim.config[:, None] == np.arange(len(base.theta))) * base.jacobian[:, :1]
    heard = noise.likely(problem.records, seen, base.residual, own, noise.measured(problem.records, seen.slide))
    base = settle(sim, heard, base)
    z, keep, code = base.whiten(base.residual), base.whiten.scale > 0, phases(sim, base.prediction)
    count = np.array([np.count_nonzero(keep & (code == k)) for k in range(4)], float)
    total = np.array([float(np.sum(z[keep & (code == k)] ** 2)) for k in range(4)])
    both = keep[1:] & keep[:-1]
    return Checked(total / np.maximum(count, 1.0), count, float(z[1:][both] @ z[:-1][both]) / float(z @ z))


def table(cases: int, seed: int) -> list[str]:
    """Return the lines of the table: per simulator the median over nulls and its 90 % range."""
    lines = [
        "| simulator | nulls | " + " | ".join(f"chi^2 {p}" for p in PHASES) + " | all, pooled | lag one |",
        "|---|---|" + "---|" * (len(PHASES) + 2),
    ]
    for simulator in NAMES:
        found = [check(simulator, seed + k) for k in range(cases)]
        chi2, samples = np.array([c.chi2 for c in found]), np.array([c.samples for c in found])
        cells = [_range(chi2[samples[:, k] > 50, k]) for k in range(len(PHASES))]
        pooled = float(np.sum(chi2 * samples) / np.sum(samples))
        lag = _range(np.array([c.lag_one for c in found]))
        lines.append(f"| {simulator} | {cases} | " + " | ".join(cells) + f" | {pooled:.3f} | {lag} |")
    return lines


def _range(x: Array) -> str:
    low, middle, high = np.quantile(x, [0.05, 0.5, 0.95])
    return f"{middle:.3f} ({low:.2f}-{high:.2f})"


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20)
    parser.add_argument("--seed", type=int, default=515)
    parser.add_argument("--out", type=Path, default=Path("docs/likelihood.md"))
    args = parser.parse_args()
    np.seterr(all="ignore")
    text = "\n".join(
        [
            "# Is the likelihood right?",
            "",
            "Recordings in which nothing is missing, drawn as the blind check draws them (rates, noises and movements differ). The base",
            "is fitted, the noise estimated from the recording itself, and the residual whitened. Right is a chi^2 of 1 per sample in",
            "every phase and no correlation between neighbours. Median over recordings (90 % range).",
            "",
            *table(args.cases, args.seed),
            "",
            f"`make likelihood` ({args.cases} recordings a simulator, seed {args.seed}). The filter itself is checked against the dense",
            "covariance in `tests/diagnosis/test_diagnosis_whitening.py` (equal to rounding).",
            "",
        ]
    )
    with atomic(args.out, force=True) as path:
        path.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()

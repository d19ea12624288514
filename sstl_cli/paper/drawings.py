"""From what was rebuilt to the paper's figures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control.controller import PHASES
from sstl_cli.identification import PHASE_NAMES
from sstl_cli.paper import figures
from sstl_cli.paper.better import TARGETS_N
from sstl_cli.paper.block_r import Tracked as RigTracked
from sstl_cli.paper.figures import Drawing, Loop, Tracked
from sstl_cli.paper.probe import FULL, Probe, curves
from sstl_cli.paper.reproduce import Reproduction
from sstl_cli.paper.settings import LOCATIONS, METHODS, TRAJECTORIES
from sstl_cli.steps.segment import Segmented

Array = NDArray[np.float64]


def drawings(found: Reproduction) -> list[Drawing]:
    """Return the figures that what was rebuilt allows."""
    done: list[Drawing] = []
    if found.slopes is not None:
        shown = {s.run.system: _loop(s) for s in found.slopes.shown}
        done += [figures.loop(shown["act"]), figures.segmentation([shown["act"], shown["sstl"]])]
        rows = found.slopes.theta.to_pylist()
        lead = {s: np.array([r["lead_mm"] for r in rows if r["system"] == s]) for s in ("act", "sstl")}
        columns = {
            s: {
                p: np.array([r[p] if r[p] is not None else np.nan for r in rows if r["system"] == s])
                for p in ("gamma_p", "gamma_r", "beta_p", "beta_r")
            }
            for s in ("act", "sstl")
        }
        both = {s: np.column_stack([columns[s]["gamma_p"], columns[s]["gamma_r"]]) for s in columns}
        done += [
            figures.correlation(both["act"], both["sstl"]),
            figures.product(lead["act"], both["act"], both["sstl"]),
            figures.parameters(lead, columns),
        ]
    if found.rig and found.rig[0].tracked is not None:
        done += _tracking(found.rig[0].tracked)
    if found.mapping is not None:
        done.append(figures.ablation(found.mapping.per_seed, found.mapping.limit.total))
    if found.better:
        first = [r for r in found.better if not r.name.startswith(("no comp", "all means"))]
        values = {t: [r.mean(t) for r in first] for t in TARGETS_N}
        done.append(figures.ladder([r.name for r in first], values, TARGETS_N))
    if found.probes:
        done.append(figures.probe({key: _curve(probes) for key, probes in curves(found.probes).items()}))
    return done


def _tracking(made: RigTracked) -> list[Drawing]:
    """Return Fig. 7: both references at every location, all methods, from block R."""
    done = []
    for letter, trajectory in zip("ab", TRAJECTORIES, strict=True):
        runs = []
        for place in LOCATIONS:
            reference = made.references[trajectory, place]
            outputs = {m: made.outputs[trajectory, m, place] for m in METHODS}
            pulling = made.phases[trajectory, place] == PHASES.index("PP")
            runs.append(Tracked(place, reference.time_s, reference.tension_n, outputs, pulling))
        done.append(figures.tracking(runs, letter, trajectory))
    return done


def _loop(one: Segmented) -> Loop:
    run, found = one.run, one.segmentation
    return Loop(run.system, run.tension_in_n, run.tension_out_n, found.phases, PHASE_NAMES, found.theta)


def _curve(probes: Sequence[Probe]) -> tuple[Array, Array, Array]:
    """Return time (s), error of the slopes and tracking error (N) of the full strokes."""
    time, lines, error = np.array([(p.time_s, p.lines_error, p.tracking_n) for p in probes if p.kind == FULL]).T
    return time, lines, error

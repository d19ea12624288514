"""Several tendons tracked at once: one tube, one sensing loop, three actuation tendons that bend the tube for one another.

Each tendon has a linear map of its own from the slopes of the shared sensing loop, as the paper's one tendon has its
network. A tendon that pulls bends the tube and with it the wrap angle of the others, theta = theta_0 (1 + c T_n): c is
identified from one recording beside a neighbour at rest and one beside a neighbour that holds, and the controller's
slopes then follow the measured input tension of the neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control import law, references
from sstl_cli.control.controller import IDENTITY, Controller, Options, Theta, loop_gain
from sstl_cli.control.plant import PRE_PULL
from sstl_cli.control.references import Reference
from sstl_cli.control.scoring import WINDOW_STEADY, score, windows
from sstl_cli.core.rng import stream
from sstl_cli.core.runs import Run
from sstl_cli.identification import segment_run
from sstl_cli.paper.bench import NOISE_N
from sstl_cli.paper.lag_and_presliding import loop_of
from sstl_cli.paper.rig import GAP, LAG_S, SPEC, Bend, bends, known, lines_of, recorded, trapezoid
from sstl_cli.physics.rig import NoiseSpec, RigRun, simulate_rig

Array = NDArray[np.float64]
#: wrap angle of each tendon over the bend's
TENDONS: Mapping[str, float] = {"A": 1.0, "B": 1.1, "C": 0.9}
#: relative change of the wrap angle per N of the neighbours: 8 % beside two tendons of 20 N
CROSSTALK_PER_N = 0.002
HELD_N = 40.0
CALIBRATION_EACH = 4
TRACKED_S = 200.0
TRACKING_DT_S = 0.01


@dataclass(frozen=True)
class Learned:
    """Maps of every tendon: slopes from (Gamma_p, Gamma_r, 1) of the sensing loop, shape (3, 2), mean biases (N); c (1/N), lag (s)."""

    slopes: Mapping[str, Array]
    biases: Mapping[str, tuple[float, float]]
    crosstalk_per_n: float
    lag_s: float

    def lines(self, tendon: str, sstl: Theta) -> Theta:
        """Return the lines of a tendon from those of the sensing loop."""
        gp, gr = np.array([sstl.gamma_p, sstl.gamma_r, 1.0]) @ self.slopes[tendon]
        return Theta(float(gp), self.biases[tendon][0], float(gr), self.biases[tendon][1])


@dataclass(frozen=True)
class Together:
    """What one way reaches: cross-talk of the rig (1/N), that identified, and the RMSE (N) of each tendon, mean over bends."""

    way: str
    crosstalk_per_n: float
    identified_per_n: float
    rmse_n: Mapping[str, float]


NONE, PUBLISHED, SCHEDULED = "no compensation", "a map each, neighbours ignored", "a map each, slopes follow the neighbours"
WAYS = (NONE, PUBLISHED, SCHEDULED)


def run(seed: int, strengths: Sequence[float] = (0.0, CROSSTALK_PER_N), each: int = CALIBRATION_EACH) -> list[Together]:
    """Return what every way reaches without and with cross-talk; all tendons follow random references of their own at once."""
    done = []
    for strength in strengths:
        learned = learn(seed, strength, each)
        found: dict[str, list[dict[str, float]]] = {way: [] for way in WAYS}
        for bend in bends(1, stream(seed, "tendons", "test")):
            sstl = known(lines_of(segment_run(recorded(bend, "sstl", *trapezoid("sstl"), seed))))
            wanted = {t: references.random(stream(seed, "tendons", bend.name, t), TRACKING_DT_S, TRACKED_S) for t in TENDONS}
            lines = {t: learned.lines(t, sstl) for t in TENDONS}
            for way in WAYS:
                per_n = learned.crosstalk_per_n if way == SCHEDULED else 0.0
                tension = together(_controllers(way, lines, learned.lag_s), wanted, {t: per_n * opening(lines[t]) for t in TENDONS}, seed)
                found[way].append(_scored(bend, tension, wanted, strength))
        for way in WAYS:
            rmse = {t: float(np.mean([f[t] for f in found[way]])) for t in TENDONS}
            done.append(Together(way, strength, learned.crosstalk_per_n, rmse))
    return done


def learn(seed: int, strength: float, each: int = CALIBRATION_EACH) -> Learned:
    """Record every tendon beside neighbours at rest, and once beside a neighbour that holds; return the maps and c."""
    sets = bends(each, stream(seed, "tendons", "calibration"))
    sstl = [known(lines_of(segment_run(recorded(b, "sstl", *trapezoid("sstl"), seed)))) for b in sets]
    x = np.array([(s.gamma_p, s.gamma_r, 1.0) for s in sstl])
    slopes, biases, changes = {}, {}, []
    for tendon in TENDONS:
        alone = [_probed(b, tendon, strength, 0.0, seed) for b in sets]
        slopes[tendon] = np.linalg.lstsq(x, np.array([(t.gamma_p, t.gamma_r) for t in alone]), rcond=None)[0]
        biases[tendon] = (float(np.mean([t.beta_p for t in alone])), float(np.mean([t.beta_r for t in alone])))
        for bend, before in zip(sets[::each], alone[::each], strict=True):
            beside = _probed(bend, tendon, strength, HELD_N, seed)
            changes.append((opening(beside) / opening(before) - 1.0) / HELD_N)
    return Learned(slopes, biases, float(np.mean(changes)), loop_of(sets[0], seed).tau_s)


def opening(lines: Theta) -> float:
    """Return mu Phi (rad) of the pass that opens the lines so far, half the logarithm of their ratio, Eq. (1)."""
    return 0.5 * math.log(lines.gamma_r / lines.gamma_p)


def _probed(bend: Bend, tendon: str, strength: float, neighbour_n: float, seed: int) -> Theta:
    time, tension = trapezoid("act")
    own = int(stream(seed, "tendons", bend.name, tendon, round(neighbour_n)).integers(2**62))
    beside = np.full(len(time), neighbour_n)
    r = simulate_rig(SPEC, _rig_run(bend, tendon, time, tension, beside), _effects(strength), NoiseSpec(), own)
    run = Run(f"{bend.name}-{tendon}", "act", r.time_s, r.tension_in_n, r.tension_out_n, bend.name, bend.location)
    return known(lines_of(segment_run(run)))


def _rig_run(bend: Bend, tendon: str, time: Array, tension: Array, beside: Array) -> RigRun:
    return RigRun("act", bend.theta * TENDONS[tendon], bend.location, time, "tension", np.maximum(tension, 0.0), beside)


def _effects(strength: float) -> dict[str, Mapping[str, float]]:
    return {**GAP, "tendon_crosstalk": {"c_bend_per_n": strength}}


def _controllers(way: str, lines: Mapping[str, Theta], lag_s: float) -> dict[str, Controller]:
    if way == NONE:
        return {t: Controller(IDENTITY, Options(dt_s=TRACKING_DT_S), compensate=False) for t in lines}
    options = Options(dt_s=TRACKING_DT_S, lead_s=lag_s, reversal="play")
    return {t: Controller(own, options) for t, own in lines.items()}


def _scored(bend: Bend, tension: Mapping[str, Array], wanted: Mapping[str, Reference], strength: float) -> dict[str, float]:
    """Return the RMSE (N) of every tendon without its first cycle, for the input tensions (N) of all of them."""
    whole = np.sum(list(tension.values()), axis=0)
    done = {}
    for t, reference in wanted.items():
        out = _output(bend, t, tension[t], np.asarray(whole - tension[t]), strength)
        part = windows(reference.time_s, reference.cycle_s)[WINDOW_STEADY]
        done[t] = score(reference.tension_n[part], out[part]).rmse_n
    return done


def together(
    controllers: Mapping[str, Controller], wanted: Mapping[str, Reference], opens_per_n: Mapping[str, float], seed: int
) -> dict[str, Array]:
    """Return the input tensions (N) of tendons that are driven side by side, each behind a tension loop of its own.

    Parameters
    ----------
    opens_per_n : mapping
        By how much (rad/N) the neighbours' measured tension opens each tendon's lines; 0 leaves them as they are.
    """
    gain = loop_gain(TRACKING_DT_S, LAG_S)
    x = {t: c.rest_tension(float(wanted[t].tension_n[0])) for t, c in controllers.items()}
    n = min(len(r.tension_n) for r in wanted.values())
    noise = {t: NOISE_N * stream(seed, "tendons", "sensor", t).standard_normal(n) for t in controllers}
    made = {t: np.empty(n) for t in controllers}
    for k in range(n):
        seen = {t: x[t] + noise[t][k] for t in controllers}
        all_n = sum(seen.values())
        for t, c in controllers.items():
            wider = opens_per_n[t] * (all_n - seen[t])
            if wider:
                c.vector[law.P_GP] = c.theta.gamma_p * math.exp(-wider)
                c.vector[law.P_GR] = c.theta.gamma_r * math.exp(wider)
            command, _ = c.step(float(wanted[t].tension_n[k]), seen[t])
            x[t] += gain * (command - x[t])
            made[t][k] = x[t]
    return made


def _output(bend: Bend, tendon: str, tension: Array, beside: Array, strength: float) -> Array:
    """Return the output (N) of one tendon beside its neighbours, all pulled from rest before the first sample."""
    both = [np.concatenate([np.linspace(0.0, v[0], PRE_PULL), v]) for v in (tension, beside)]
    time = np.arange(len(both[0]), dtype=np.float64) * TRACKING_DT_S
    r = simulate_rig(SPEC, _rig_run(bend, tendon, time, *both), _effects(strength), NoiseSpec(white_n=0.0))
    return r.tension_out_n[PRE_PULL:]

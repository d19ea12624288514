"""Write how closely the fast model, refitted, follows a simulator that stands in for hardware under each effect.

Usage: python tools/effects_table.py [--out docs/effects.md]      the rig
       python tools/effects_table.py --simulator bristle           the bristle simulator, into docs/bristle.md
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from sstl_cli.core.files import atomic
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import noise
from sstl_cli.diagnosis.constants import COARSE_ITERATIONS
from sstl_cli.diagnosis.fit import Fit, fit, settle
from sstl_cli.diagnosis.found import NOTHING
from sstl_cli.diagnosis.free import Free
from sstl_cli.diagnosis.hypotheses import Hypothesis, full, variants
from sstl_cli.diagnosis.neighbours import with_neighbours
from sstl_cli.diagnosis.records import prepare
from sstl_cli.diagnosis.simulator import Simulator
from sstl_cli.diagnosis.starts import grid
from sstl_cli.diagnosis.whitening import white
from sstl_cli.physics.effects import catalogue, get
from sstl_cli.physics.scenario import Configuration, NoiseSection, Scenario, Tendon, Trajectory
from sstl_cli.physics.transmission import activate, measure, predict, predict_position
from sstl_cli.physics.transmission.model import drive_of
from sstl_cli.steps import simulate

Array = NDArray[np.float64]
Strengths = dict[str, float]

# a clearly visible strength of each effect (about 0.1-0.6 N in the output), every system's own parameter set
CASES: dict[str, Strengths] = {
    "acquisition_faults": {"spike_pct": 0.5, "frozen_pct": 0.5},
    "asymmetric_friction": {"a": 0.08},
    "channel_delay": {"tau_act_s": 0.06, "tau_sstl_s": 0.09},
    "channel_lowpass": {"tau_act_s": 0.06, "tau_sstl_s": 0.09},
    "const_friction": {"w_l_n": 0.3},
    "crosstalk": {"c_in_to_out": 0.02, "c_out_to_in": 0.015},
    "dwell_aging": {"b": 0.04},
    "friction_drift": {"d_mu": 0.2, "path_n": 200.0},
    "gain_error": {"g_act": 1.04, "g_sstl": 0.95},
    "load_dependent_friction": {"alpha": 0.15},
    "load_spring": {"k3_per_mm2": 0.05, "play_mm": 0.8},
    "presliding": {"breakaway_mm": 0.2},
    "pulley_friction": {"m_p": 0.1, "m_r": 0.06, "f0_n": 0.3},
    "quantisation": {"q_in_n": 0.1, "q_out_n": 0.2},
    "saturation": {"t_max_in_n": 25.0, "t_max_out_n": 12.0},
    "sensor_nonlinearity": {"a_in": 0.01, "a_out": -0.012, "h_n": 0.05},
    "sheath_compliance": {"c_t_per_n": 0.005},
    "slack": {"gap_mm": 2.0},
    "stick_slip": {"ratio": 1.06, "v_c_mm_s": 1.0},
    "stribeck": {"ratio": 1.05, "v_s_mm_s": 3.0},
    "tendon_crosstalk": {"c_bend_per_n": 0.006},
    "tendon_elasticity": {"compliance_per_kn": 0.2},
    "tension_loop_lag": {"tau_s": 0.1, "inverse_slew_s_per_n": 0.05},
    "viscoelastic_creep": {"fraction": 0.2, "tau_s": 10.0},
    "viscous": {"c_l_n_s_per_mm": 0.03},
    "zero_drift": {"r_in_act_n": 0.3, "r_out_act_n": -0.4, "r_in_sstl_n": 0.2, "r_out_sstl_n": 0.3},
    "zero_offset": {"z_in_act_n": 0.3, "z_out_act_n": -0.4, "z_in_sstl_n": -0.3, "z_out_sstl_n": 0.2},
}
THETA_START = 0.5
# compliance of the tendon as built (1/kN): the rig's position always contains its stretch
AS_BUILT = {"tendon_elasticity": {"compliance_per_kn": 0.125}}


@dataclass(frozen=True)
class Refit:
    """The fast model refitted to recordings with one effect: parameters, fit, the base without it, and the records."""

    free: tuple[Free, ...]
    fit: Fit
    base: Fit
    sim: Simulator

    @property
    def rms_n(self) -> float:
        """RMS of the residual at the analysis rate (N)."""
        return float(np.sqrt(np.average(self.fit.residual**2, weights=self.sim.weight)))


def scenario(simulator: str = "rig", white_n: float = 0.0, hz: float = 100.0) -> Scenario:
    """Return two configurations at NP and ND and three movements with reference and position recorded."""
    record: dict[str, Any] = {"record_reference": True, "record_position": True}
    return Scenario(
        simulator=simulator,  # type: ignore[arg-type]
        sampling_hz=hz,
        noise=NoiseSection(white_n=white_n),
        configurations=(Configuration(id="a", location="NP", theta=0.46), Configuration(id="b", location="ND", theta=0.60)),
        trajectories=(
            Trajectory(kind="trapezoid", drive="tension", duration_s=12.0, cycles=2, low_n=0.0, **record),
            Trajectory(kind="ramp_hold", duration_s=40.0, **record),
            Trajectory(kind="minor_loops", duration_s=40.0, **record),
        ),
    )


def record(effect_id: str | None, simulator: str = "rig", white_n: float = 0.0, seed: int = 3) -> list[Run]:
    """Return the recordings of the scenario with one effect at its strength, or without any."""
    effects = {effect_id: CASES[effect_id]} if effect_id else {}
    return list(simulate.run(scenario(simulator, white_n), effects, seed))


def _law(effect_id: str, systems: Sequence[str]) -> Hypothesis:
    """Return the law of an effect that its case is of, with everything free in it; the shapes of another law show nothing."""
    stated = set(CASES.get(effect_id, {}))
    laws = [h for h in variants(effect_id, systems) if stated & {f.parameter.name for f in h.strengths}]

    def fits(h: Hypothesis) -> tuple[int, int]:
        # a shape that the case says nothing of is another law's
        unsaid = sum(f.parameter.shape and f.effect.id == effect_id and f.parameter.name not in stated for f in h.free)
        return -unsaid, len(h.free)

    return max(laws, key=fits) if get(effect_id).variants and laws else full(effect_id, systems)


def refit(effect_id: str, runs: list[Run], noisy: bool = True) -> Refit:
    """Return the fast model with theta and the parameters of one effect fitted to recordings, whitened where they are ``noisy``."""
    problem = prepare(runs)
    sim = Simulator(problem, scenario().rig.mechanics())
    # what only the position shows cannot be fitted to tensions; the load is known here
    free = [f for f in _law(effect_id, problem.systems).free if f.effect.id == effect_id and f.parameter.name != "k_sh_mm_per_n"]
    plain = white(0.05, sim.weight, [s.start for s in sim.slices()])
    base = fit(sim, plain, NOTHING, np.full(len(problem.configs), THETA_START), np.zeros(0))
    hypothesis = Hypothesis((effect_id,), tuple(free))
    tries = (fit(sim, plain, hypothesis, base.theta, s, COARSE_ITERATIONS) for s in grid(free))
    found = min(tries, key=lambda f: f.cost)
    found = fit(sim, plain, hypothesis, found.theta, found.values)
    if noisy:
        found = settle(sim, noise.measured(problem.records, sim.phases(found.theta, found.effects).slide), found)
    return Refit(tuple(free), found, base, sim)


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))


def _joined(runs: list[Run], name: str) -> Array:
    return np.concatenate([getattr(r, name) for r in runs])


def _out_row(effect_id: str, clean: list[Run], simulator: str) -> tuple[str, float, float]:
    runs = record(effect_id, simulator)
    strength = _rms(_joined(runs, "tension_out_n") - _joined(clean, "tension_out_n"))
    return "output, N", strength, refit(effect_id, runs, noisy=False).rms_n


def _neighbour_row(effect_id: str, simulator: str) -> tuple[str, float, float]:
    """Compare the first of two tendons, whose neighbour moves alike 7 s later."""
    two = scenario(simulator).model_copy(update={"tendons": (Tendon(id="A"), Tendon(id="B", delay_s=7.0))})
    together = [list(simulate.run(two, effects, 3)) for effects in ({}, {effect_id: CASES[effect_id]})]
    clean, runs = ([with_neighbours(r, rs) for r in rs if r.tendon == "A"] for rs in together)
    strength = _rms(_joined(runs, "tension_out_n") - _joined(clean, "tension_out_n"))
    return "output, N", strength, refit(effect_id, runs, noisy=False).rms_n


def _recorder_row(effect_id: str, clean: list[Run], simulator: str) -> tuple[str, float, float | None]:
    runs = record(effect_id, simulator)
    strength = _rms(_joined(runs, "tension_out_n") - _joined(clean, "tension_out_n"))
    if effect_id == "acquisition_faults":
        return "output, N", strength, None
    active = activate({effect_id: CASES[effect_id]})
    seen = [measure(r.system, r.dt_s, r.tension_in_n, r.tension_out_n, active)[1] for r in clean]
    return "output, N", strength, _rms(np.concatenate(seen) - _joined(runs, "tension_out_n"))


def _loop_row(effect_id: str, clean: list[Run], simulator: str) -> tuple[str, float, float]:
    runs, effect = record(effect_id, simulator), get(effect_id)
    strength = _rms(_joined(runs, "tension_in_n") - _joined(clean, "tension_in_n"))

    def residual(x: Array) -> Array:
        values = effect.complete(dict(zip((p.name for p in effect.parameters), x.tolist(), strict=True)))
        assert effect.loop is not None
        lagged = [effect.loop(np.asarray(r.tension_ref_n), r.dt_s, values) for r in runs]
        return np.concatenate(lagged) - _joined(runs, "tension_in_n")

    return "input, N", strength, _rms(_least(residual, effect_id))


def _position_row(effect_id: str, clean: list[Run], simulator: str) -> tuple[str, float, float]:
    runs = record(effect_id, simulator)
    strength = _rms(np.concatenate([_centred(a) - _centred(b) for a, b in zip(runs, clean, strict=True)]))
    effect, mechanics = get(effect_id), scenario().rig.mechanics()
    theta = {c.id: c.theta or 0.0 for c in scenario().configurations}

    def residual(x: Array) -> Array:
        values = effect.complete(dict(zip((p.name for p in effect.parameters), x.tolist(), strict=True)))
        active = activate({**AS_BUILT, effect_id: values})
        parts = []
        for r in runs:
            drive = drive_of(r.system, r.location, r.dt_s, r.tension_in_n, mechanics)
            # the rig is brought from its pretension to the first sample
            out = predict(drive, theta[str(r.config_id)], active, 5.0)
            found = predict_position(drive, theta[str(r.config_id)], active, out)
            parts.append(found - found.mean() - _centred(r))
        return np.concatenate(parts)

    return "position, mm", strength, _rms(_least(residual, effect_id))


def _centred(run: Run) -> Array:
    position = np.asarray(run.position_in_mm)
    return position - position.mean()


def _least(residual: Any, effect_id: str) -> Array:
    """Return the smallest residual over the bounds of an effect, started a fifth of the way."""
    low = np.array([p.low for p in get(effect_id).parameters])
    high = np.array([p.high for p in get(effect_id).parameters])
    start = low + 0.2 * (high - low)
    found = least_squares(residual, start, bounds=(low, high), x_scale=high - low, diff_step=np.full(len(low), 1e-3), max_nfev=40)
    return np.asarray(found.fun)


def row(effect_id: str, clean: list[Run], simulator: str = "rig") -> tuple[str, float, float | None]:
    """Return channel and unit, RMS of the effect in the simulator, and RMS difference of the refitted fast model."""
    effect = get(effect_id)
    if effect.channel == "position":
        return _position_row(effect_id, clean, simulator)
    if effect.channel == "loop":
        return _loop_row(effect_id, clean, simulator)
    if effect.channel == "neighbour":
        return _neighbour_row(effect_id, simulator)
    return (_out_row if effect.fitted else _recorder_row)(effect_id, clean, simulator)


def rows(simulator: str = "rig") -> list[str]:
    """Return the table as lines of Markdown."""
    clean = record(None, simulator)
    lines = [f"| effect | strength | channel | RMS of the effect | RMS fast model - {simulator} | left |", "|---|---|---|---:|---:|---:|"]
    for effect_id in catalogue():
        if effect_id not in CASES:
            continue
        channel, strength, left = row(effect_id, clean, simulator)
        values = ", ".join(f"{k} {v:g}" for k, v in CASES[effect_id].items())
        shown = "random" if left is None else f"{left:.4f}"
        share = "" if left is None else f"{100.0 * left / strength:.1f} %"
        lines.append(f"| `{effect_id}` | {values} | {channel} | {strength:.4f} | {shown} | {share} |")
    return lines


def page() -> str:
    """Return the rig's page as Markdown."""
    lines = [
        "# Fast model against rig, effect by effect",
        "",
        "Written by `python tools/effects_table.py`. The rig records two configurations (NP, theta 0.46; ND, theta 0.60),",
        "actuation and SSTL, three movements, 100 Hz, without noise. The fast model is then refitted: theta of each",
        "configuration and the parameters of the effect. The stiffness of the load is known. Effects of the recorder are",
        "applied to the rig's clean record instead; random faults have no counterpart to compare. `tendon_crosstalk` is",
        "judged on the actuation runs of the first of two tendons, the second moving alike 7 s later.",
        "",
        *rows(),
    ]
    lines += [
        "",
        "Friction that weakens with speed (`stribeck`, `stick_slip`) makes an elastic line jump; when it jumps depends on",
        "the number of nodes (30 a pass in the rig, 6 in the fast model), so only size and shape of the sawtooth agree.",
        "`presliding` spreads its break-away distances over different nodes in the two. `viscoelastic_creep` differs in how",
        "far the creep has come at the first sample, `load_spring` in the side of its joint on which a run starts.",
        "`dwell_aging` is small here: what is left of it is the same few mN as elsewhere.",
        "",
    ]
    return "\n".join(lines)


def main() -> None:
    """Write the page of the rig, or the table of the bristle simulator into its page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--simulator", choices=("rig", "bristle"), default="rig")
    parser.add_argument("--out", type=Path, default=Path("docs/effects.md"), help="page of the rig")
    given = parser.parse_args()
    if given.simulator == "bristle":
        from page_part import put

        put("bristle.md", "effects", "\n".join(rows("bristle")))
        return
    text = page()
    with atomic(given.out, force=True) as path:
        path.write_text(text)
    print(text)


if __name__ == "__main__":
    main()

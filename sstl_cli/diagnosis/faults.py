"""What recorder faults explain of the gap, measured against the best model of the rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainccinv

from sstl_cli.diagnosis.constants import CLIPPED_SIGMA, DECIDES_NATS, FEW, FINE_STEP, HALF, LEAST_GAP, LEAST_SHARE
from sstl_cli.diagnosis.evidence import Weighed
from sstl_cli.diagnosis.features import RECORDER, CandidateRow
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.found import Search
from sstl_cli.diagnosis.noise import of_readings
from sstl_cli.diagnosis.readings import gaps
from sstl_cli.diagnosis.recorder import Faults
from sstl_cli.diagnosis.records import Record
from sstl_cli.physics.scenario import Scenario

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RecorderEffect:
    """A fault of the recorder that carries part of the squared error; ``events`` is in how many readings of equal weight.

    ``total_n2`` is the squared error of all readings, of which ``removed_n2`` is the fault's.
    """

    id: str
    share: float
    parameters: dict[str, float]
    removed_n2: float
    noise_n: float
    events: float = np.inf
    total_n2: float = np.inf

    @property
    def nats(self) -> float:
        """What taking the fault out gains."""
        return 0.5 * self.removed_n2 / max(self.noise_n, 1e-12) ** 2

    @property
    def at_most_n2(self) -> float:
        """The squared error that as many events could as well have brought, at 49 to 1 (N^2): their number is a matter of chance."""
        if not np.isfinite(self.events):
            return self.removed_n2
        return self.removed_n2 * float(gammainccinv(self.events + 1.0, np.exp(-DECIDES_NATS))) / self.events

    @property
    def fall_pct(self) -> float:
        """By how many percent the error (RMS) of all readings falls without the fault."""
        return 100.0 * (1.0 - float(np.sqrt(max(1.0 - self.removed_n2 / max(self.total_n2, 1e-300), 0.0))))

    def row(self) -> CandidateRow:
        """Return the fault as a candidate of the verdict."""
        return CandidateRow((self.id,), RECORDER, 1, self.nats, self.nats, self.nats, 1.0, 0.0, 0.0, 0, 1.0, self.share)


@dataclass
class _Carried:
    """What readings carry of the squared error (N^2): spoilt ones, clipped ones, all, and at most by rounding; with their counts.

    Beside them what spoilt and clipped ones carry over the square of their own sensor's noise, and the noise of all readings (N^2), as
    it is and without what rounding adds to it.
    """

    faulty: float = 0.0
    fourth: float = 0.0
    clipped: float = 0.0
    total: float = 0.0
    stepped: float = 0.0
    faulty_over_noise: float = 0.0
    clipped_over_noise: float = 0.0
    noise: float = 0.0
    unrounded: float = 0.0
    spikes: int = 0
    frozen: int = 0
    readings: int = 0
    clips: int = 0
    level_in: float = np.inf
    level_out: float = np.inf
    step_in: float = 0.0
    step_out: float = 0.0

    def add(self, r: Record, prediction: Array, noise_n: float) -> None:
        """Count a record."""
        expected, error2, input_error2 = squared_errors(r, prediction)
        n = len(expected)
        bad_in, bad_out = r.faults_in.bad[:n], r.faults_out.bad[:n]
        self.total += float(error2.sum() + input_error2.sum())
        # what sound readings are off by, too, is not the fault's
        sound = (r.raw_weight[:n] > 0.0) & ~bad_in & ~bad_out & ~r.faults_out.clipped[:n]
        usual = float(error2[sound].mean()) if sound.any() else 0.0
        faulty = max(float(error2[bad_out].sum() + input_error2[bad_in].sum()) - usual * int(bad_out.sum()), 0.0)
        before = self.clipped
        self.fourth += float((error2[bad_out] ** 2).sum() + (input_error2[bad_in] ** 2).sum())
        self.clipped += float(input_error2[~bad_in].sum())
        self.spikes += int(r.faults_in.spike.sum() + r.faults_out.spike.sum())
        self.frozen += int(r.faults_in.frozen.sum() + r.faults_out.frozen.sum())
        recorded = int((gaps(r.raw)[:n] == 0).sum())
        self.readings += recorded
        self._add_clipped(r, expected, error2, noise_n, usual)
        self.faulty += faulty
        self.faulty_over_noise += faulty / noise_n**2
        self.clipped_over_noise += (self.clipped - before) / noise_n**2
        self.noise += recorded * noise_n**2
        self.unrounded += recorded * max(noise_n**2 - r.faults_out.rounding_n**2, 0.0)
        self.step_in, self.step_out = max(self.step_in, r.faults_in.step_n), max(self.step_out, r.faults_out.step_n)
        slope = np.exp(0.5 * r.raw.passes)
        self.stepped += recorded * (_coarse(r.faults_out) + slope**2 * _coarse(r.faults_in) / 4.0) / 12.0

    def _add_clipped(self, r: Record, expected: Array, error2: Array, noise_n: float, usual: float) -> None:
        n = len(expected)
        for faults, is_out in ((r.faults_in, False), (r.faults_out, True)):
            hit = faults.clipped[:n]
            if not hit.any():
                continue
            self.clips += int(hit.sum())
            # the clipped input falsifies the output until it is forgotten: all of the masked part counts
            part = hit if is_out else (r.raw_weight[:n] == 0.0)
            # a level that a rounded reading repeats is no limit unless the tension goes beyond what rounds to it
            rounding = 0.5 * faults.step_n * (1.0 if is_out else np.exp(0.5 * r.raw.passes))
            beyond = part & (error2 > (rounding + noise_n) ** 2)
            over = beyond & (expected > r.raw.tension_out_n[:n]) if is_out else beyond
            self.clipped += max(float(error2[over].sum()) - usual * int(over.sum()), 0.0)
            if is_out:
                self.level_out = min(self.level_out, faults.clip_level_n)
            else:
                self.level_in = min(self.level_in, faults.clip_level_n)


def squared_errors(r: Record, prediction: Array) -> tuple[Array, Array, Array]:
    """Return what is expected of the output (N), and squared errors (N^2) of output and input, the latter of spoilt readings alone.

    All have shape (n,), with no error where nothing was recorded. A reading at a limit is off by how far the input went beyond it, where that is more than noise.
    """
    thin = max(1, len(r.raw) // max(len(prediction), 1))
    expected = np.repeat(prediction, thin)
    n = len(expected)
    off = np.repeat(r.u, thin)[:n] - r.raw.tension_in_n[:n]
    beyond = r.faults_in.clipped[:n] & (off > CLIPPED_SIGMA * r.faults_in.noise_n)
    recorded = gaps(r.raw)[:n] == 0
    into = np.where((r.faults_in.bad[:n] | beyond) & recorded, off**2, 0.0)
    return expected, np.where(recorded, (r.raw.tension_out_n[:n] - expected) ** 2, 0.0), into


def recorder_effects(
    records: tuple[Record, ...], predictions: list[Array], noise_n: Sequence[float], known: Mapping[str, float] = MappingProxyType({})
) -> list[RecorderEffect]:
    """Return recorder faults that carry a substantial share of the squared error, largest first.

    Parameters
    ----------
    predictions : list of ndarray
        Output of the re-tuned base on each record's simulation grid (N).
    noise_n : sequence of float
        Noise of the readings of each record's output (N); error below it is nobody's fault.
    known : mapping, optional
        Squared error (N^2) a reading that faults are known to carry: that much of it is no news.
    """
    c = _Carried()
    for r, prediction, own_n in zip(records, predictions, noise_n, strict=True):
        c.add(r, prediction, own_n)
    events = c.faulty**2 / c.fourth if c.fourth > 0.0 else np.inf
    before = {k: v * c.readings for k, v in known.items()}
    faulty = max(c.faulty - before.get("acquisition_faults", 0.0), 0.0)
    clipped = max(c.clipped - before.get("saturation", 0.0), 0.0)
    excess = max(c.total - c.noise, 1e-12)
    found = []
    if c.spikes + c.frozen >= FEW and faulty > 0.0:
        values = {"spike_pct": 100.0 * c.spikes / (2 * c.readings), "frozen_pct": 100.0 * c.frozen / (2 * c.readings)}
        own_n = _noise_n(c.faulty, c.faulty_over_noise)
        found.append(RecorderEffect("acquisition_faults", min(faulty / excess, 1.0), values, faulty, own_n, events, c.total))
    if c.clips and clipped > 0.0:
        levels = {"t_max_in_n": c.level_in, "t_max_out_n": c.level_out}
        values = {k: float(v) for k, v in levels.items() if np.isfinite(v)}
        own_n = _noise_n(c.clipped, c.clipped_over_noise)
        found.append(RecorderEffect("saturation", min(clipped / excess, 1.0), values, clipped, own_n, total_n2=c.total))
    rest = max(c.total - faulty - clipped, 1e-12)
    stepped = max(c.stepped - before.get("quantisation", 0.0), 0.0)
    # the noise was measured on rounded samples: what rounding adds to it is no noise; beside a larger one, known to a few percent only,
    # nobody can say what a fine converter carries; nor is there anything that it carries where noise explains all
    beyond, usual = rest - c.unrounded, c.noise / max(c.readings, 1)
    if beyond > 0.0 and min(stepped, rest) > max(2.0 * usual, LEAST_GAP * c.unrounded):
        values = {"q_in_n": c.step_in, "q_out_n": c.step_out}
        share = min(stepped / max(beyond, stepped), 1.0)
        found.append(RecorderEffect("quantisation", share, values, min(stepped, rest), float(np.sqrt(usual)), total_n2=c.total))
    # what carries next to nothing of the error is no cause of it
    return sorted((e for e in found if e.share >= LEAST_SHARE), key=lambda e: -e.share)


def _noise_n(carried_n2: float, over_noise: float) -> float:
    """Return the noise (N) of the sensors of a fault, each by what it carries there."""
    return float(np.sqrt(carried_n2 / over_noise)) if over_noise > 0.0 else 0.0


def _coarse(f: Faults) -> float:
    """Return the square of a converter's step (N^2) beyond that which the noise smooths over (Widrow and Kollar 2008)."""
    noise2 = max(f.noise_n**2 - f.rounding_n**2, 0.0)
    return max(f.step_n**2 - FINE_STEP**2 * noise2, 0.0)


def once(found: Search, recorder: Sequence[RecorderEffect], beside: Callable[[Weighed], Sequence[RecorderEffect]]) -> Search:
    """Return a search without models of what the recorder shows in its readings already, unless one leads and explains those, too."""
    lead = next(iter(found.ranked()), None)
    told = {e.id for e in recorder}
    if lead is not None and told & set(lead.ids):
        left = {e.id: e.removed_n2 for e in beside(lead)}
        told = {e.id for e in recorder if e.id not in lead.ids or left.get(e.id, 0.0) > HALF * e.removed_n2}
    singles = {k: v for k, v in found.singles.items() if k not in told}
    return replace(found, singles=singles, combined={k: v for k, v in found.combined.items() if not told & set(k)})


def beyond(found: Search, scenario: Scenario, lacking: int | None = None, beside: Fit | None = None) -> list[RecorderEffect]:
    """Return the faults of the recorder beyond those that a simulator knows, candidates or not, largest first.

    They are what the base misses of readings, or a model that they stand beside.

    Parameters
    ----------
    scenario : Scenario
        The simulator, in the units of the recording.
    lacking : int, optional
        The run (its place) that is left out.
    beside : Fit, optional
        The model that they stand beside (default: the base).
    """
    sim = found.sim
    known = {k: v / sim.problem.unit_n**2 for k, v in scenario.faults.items()}
    # readings are compared one by one, not their means over a step of the simulation
    read = of_readings(sim.problem.records, found.noise)
    runs = [i for i in range(len(sim.problem.records)) if i != lacking]
    at = beside or found.base
    predictions = sim.predict_fine(at.theta, at.effects)
    records = tuple(sim.problem.records[i] for i in runs)
    own = [(read.output[r.system], r) for r in records]
    noise_n = [max(float(np.hypot(s.white_n * r.louder, s.coloured_n * r.slower)), 1e-9) for s, r in own]
    seen = recorder_effects(records, [predictions[i] for i in runs], noise_n, known)
    return [e for e in seen if e.id not in scenario.effects]

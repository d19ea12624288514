"""What a report is made of: every input in memory, logs and commands already thinned for drawing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.documents.control import ScoreRow
from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.core.runs import Run
from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.reduce import keep
from sstl_cli.reporting.rows import Epoch, Evaluated, Predicted
from sstl_cli.reporting.scored import Scored

Array = NDArray[np.float64]
PHASE_CODES = ("PB", "PP", "RB", "RP")
STRETCHES = 160


@dataclass(frozen=True)
class Segments:
    """Phases of one run as stretches: start times in s and phase codes, ascending in time."""

    start_s: Array
    code: NDArray[np.int8]

    def at(self, time_s: Array) -> NDArray[np.int8]:
        """Return the phase code at each time, -1 before the first stretch."""
        place = np.searchsorted(self.start_s, time_s, side="right") - 1
        return np.where(place >= 0, self.code[np.maximum(place, 0)], -1).astype(np.int8)


@dataclass(frozen=True)
class RunView:
    """A run as it is shown: labels, a thinned record, and what a sampling check found at full rate."""

    run_id: str
    system: str
    config_id: str | None
    location: str | None
    trajectory: str | None
    lead_mm: float | None
    time_s: Array
    tension_in_n: Array
    tension_out_n: Array
    samples: int
    duration_s: float
    period_s: float
    jitter_pct: float
    gap_s: float
    missing: int
    input_range_n: tuple[float, float]
    output_range_n: tuple[float, float]

    @property
    def remark(self) -> str:
        """What the sampling check has to say, in words."""
        found = []
        if self.missing:
            found.append(f"{self.missing} samples without a value")
        if self.period_s > 0 and self.gap_s > 3 * self.period_s:
            found.append(f"gap of {self.gap_s:.3g} s")
        if self.jitter_pct > 10:
            found.append("uneven sampling")
        return "; ".join(found) or "even"


@dataclass(frozen=True)
class CommandView:
    """One run under one method: a thinned record and the squared error by phase at full rate."""

    run_id: str
    method: str
    time_s: Array
    reference_n: Array
    output_n: Array
    rmse_by_phase_n: dict[str, float]
    rmse_n: float

    @property
    def subject(self) -> str:
        """What the methods are compared on: the run_id without the name of the method at its end."""
        bare = self.run_id.removesuffix(self.method)
        return bare.rstrip("-_/: ") or self.run_id if bare != self.run_id else self.run_id


@dataclass(frozen=True)
class Model:
    """A weights file by its header: free-text metadata and (name, type, shape) of every tensor."""

    name: str
    metadata: dict[str, str]
    tensors: list[tuple[str, str, list[int]]]

    @property
    def parameters(self) -> int:
        return sum(int(np.prod(shape)) for _, _, shape in self.tensors)


@dataclass(frozen=True)
class EffectNote:
    """What the page says of an effect: its title, equation, source, what shows it, and what its parameters mean."""

    title: str
    stage: str
    equation: str
    source: str
    excitation: str
    meanings: dict[str, str]


@dataclass(frozen=True)
class Inputs:
    """All inputs of one report by kind; a kind that was not given is empty.

    ``left_out`` counts the runs of each log that are too short and too many to be kept.
    """

    log: list[RunView] = field(default_factory=list)
    theta: list[ThetaRow] = field(default_factory=list)
    phases: dict[str, Segments] = field(default_factory=dict)
    history: list[Epoch] = field(default_factory=list)
    evaluation: list[Evaluated] = field(default_factory=list)
    evaluate: list[tuple[str, Mapping[str, object]]] = field(default_factory=list)
    predictions: list[Predicted] = field(default_factory=list)
    model: list[Model] = field(default_factory=list)
    command: list[CommandView] = field(default_factory=list)
    score: list[ScoreRow] = field(default_factory=list)
    diagnosis: list[Diagnosed] = field(default_factory=list)
    blind: list[Scored] = field(default_factory=list)
    document: list[tuple[str, Mapping[str, object]]] = field(default_factory=list)
    files: list[tuple[str, str, str]] = field(default_factory=list)
    left_out: dict[str, int] = field(default_factory=dict)
    catalogue: dict[str, EffectNote] = field(default_factory=dict)

    def has(self, kinds: Iterable[str]) -> bool:
        """Tell whether at least one of these kinds was given."""
        return any(getattr(self, kind) for kind in kinds)


def view(run: Run) -> RunView:
    """Return a run as it is shown: thinned to its extremes, with its sampling measured at full rate."""
    step = np.diff(run.time_s)
    period = float(np.median(step)) if len(step) else float("nan")
    # decimals of a time stamp are not jitter
    spread = round(float(np.std(step) / period * 100), 6) if len(step) and period > 0 else float("nan")
    index = keep([run.tension_in_n, run.tension_out_n], STRETCHES)
    gaps = np.isnan(run.tension_in_n) | np.isnan(run.tension_out_n)
    return RunView(
        run.run_id,
        run.system,
        run.config_id,
        run.location,
        run.trajectory,
        run.lead_mm,
        run.time_s[index],
        run.tension_in_n[index],
        run.tension_out_n[index],
        samples=len(run),
        duration_s=float(run.time_s[-1] - run.time_s[0]),
        period_s=period,
        jitter_pct=spread,
        gap_s=float(step.max()) if len(step) else float("nan"),
        missing=int(gaps.sum()),
        input_range_n=_range(run.tension_in_n),
        output_range_n=_range(run.tension_out_n),
    )


def command_view(run_id: str, method: str, columns: dict[str, Array], phase: NDArray[np.int8]) -> CommandView:
    """Return one method's record thinned, and its RMSE in N by phase at full rate.

    Parameters
    ----------
    columns : dict of ndarray, shape (n,)
        time_s in s, tension_ref_n and tension_out_n in N.
    phase : ndarray of int8, shape (n,)
        Index into PHASE_CODES, -1 where unknown.
    """
    time, reference, output = (columns[c] for c in ("time_s", "tension_ref_n", "tension_out_n"))
    error = output - reference
    by_phase = {name: rms(error[phase == i]) for i, name in enumerate(PHASE_CODES)}
    index = keep([reference, output], STRETCHES)
    return CommandView(run_id, method, time[index], reference[index], output[index], by_phase, rms(error))


def segments(time_s: Array, code: NDArray[np.int8]) -> Segments:
    """Return per-sample phases as stretches of equal phase."""
    starts = np.concatenate(([0], np.flatnonzero(np.diff(code)) + 1)) if len(code) else np.empty(0, dtype=np.intp)
    return Segments(time_s[starts], code[starts])


def rms(error: Array) -> float:
    """Return the root mean square of what is there, NaN where nothing is."""
    good = error[~np.isnan(error)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else float("nan")


def _range(values: Array) -> tuple[float, float]:
    good = values[~np.isnan(values)]
    return (float(good.min()), float(good.max())) if len(good) else (float("nan"), float("nan"))

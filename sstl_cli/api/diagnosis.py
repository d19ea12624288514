"""The diagnosis of a log as an object: tables, pictures, a page, and the accepted simulator."""

from __future__ import annotations

import base64
import html
import io
import json
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from sstl_cli.api.log import Log
from sstl_cli.core.aside import kept_apart, open_ledger
from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Gap, Verdict
from sstl_cli.core.files import dumps, write_text
from sstl_cli.core.provenance import inputs_of
from sstl_cli.core.runs import Run, few_short
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.physics.scenario_file import dump
from sstl_cli.reporting import drawing
from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.documents import read
from sstl_cli.reporting.inputs import Inputs, view
from sstl_cli.steps import diagnose_movements, diagnose_tendons
from sstl_cli.steps.diagnose import DiagnoseOptions, odds
from sstl_cli.steps.plot import run as choose
from sstl_cli.steps.report import DEFAULT_TITLE
from sstl_cli.steps.report import run as make_page

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "diagnosis"
SHOWN = 6


@dataclass(frozen=True)
class Diagnosis:
    """Where the gap lies, which effect causes it, how far it shrinks; see docs/diagnosis.md.

    Attributes
    ----------
    log : Log
        What was diagnosed.
    document : DiagnosisDocument
        The document ``sstl.diagnosis/1``, as ``sstl diagnose --json`` prints it.
    accepted : Scenario
        The accepted simulator, effects included.
    """

    log: Log
    document: DiagnosisDocument
    accepted: Scenario
    _known: Callable[[], Scenario] | None = field(default=None, repr=False)
    _remark: str = field(default="", repr=False)

    @property
    def verdict(self) -> Verdict:
        """Status, effects, confidence and why."""
        return self.document.verdict

    @property
    def gap(self) -> Gap:
        """The error step by step, and how far it shrinks."""
        return self.document.gap

    @property
    def sentence(self) -> str:
        """The diagnosis in one sentence."""
        return self.document.sentence or self.verdict.why

    @property
    def where(self) -> pd.DataFrame:
        """Shares of the squared error by system, phase and configuration, largest first."""
        columns = ["system", "phase", "config_id", "share_pct", "rmse_n"]
        return pd.DataFrame([p.model_dump() for p in self.document.where], columns=columns)

    @property
    def candidates(self) -> pd.DataFrame:
        """One row a candidate, most probable first, with the samples that its errors are of; its parameters stand in ``parameters``."""
        columns = ["id", "probability", "rmse_held_out_n", "shrink_pct", "identifiability", "sensor", "d2", "samples"]
        return pd.DataFrame([c.model_dump() for c in self.document.candidates], columns=columns)

    @property
    def parameters(self) -> pd.DataFrame:
        """One row a parameter of a candidate: estimate, 95 % interval or why there is none, unit."""
        columns = ["candidate", "name", "unit", "estimate", "ci95_low", "ci95_high", "at_bound", "why"]
        rows = [
            (c.id, p.name, p.unit, p.estimate, *(p.ci95 or (None, None)), p.at_bound, p.why)
            for c in self.document.candidates
            for p in c.parameters
        ]
        return pd.DataFrame(rows, columns=columns)

    def plot(self, kind: str | None = None, tendon: str | None = None) -> Figure:
        """Return a figure of the report: the gap step by step, or another ``kind`` of ``sstl plot``.

        Of several tendons it shows the one with the largest gap, or the one that is named.

        Raises
        ------
        SstlError
            If there is no such figure, or the diagnosis holds nothing for it.
        """
        choice = choose(self._inputs(), kind, tendon=tendon)
        return drawing.drawn(choice.module, choice.data, choice.title)

    def report(self, path: str | PathLike[str], title: str = DEFAULT_TITLE, force: bool = False) -> None:
        """Write one self-contained HTML page of log and diagnosis, whole or not at all."""
        write_text(Path(path), make_page(self._inputs(with_log=True), title).html, force)

    def to_dict(self) -> dict[str, Any]:
        """Return a copy of the JSON document."""
        copied: dict[str, Any] = json.loads(dumps(self.document.plain()))
        return copied

    def model(self) -> Scenario:
        """Return the accepted simulator with what it is known to leave of this log, which it is tried on once.

        ``sstl.simulate`` and ``sstl.diagnose(log, sim=...)`` take it; ``accepted`` is the simulator alone.
        """
        return self.accepted if self._known is None else self._known()

    def save_model(self, path: str | PathLike[str], force: bool = False) -> None:
        """Write that simulator as a scenario TOML, as ``--save-sim`` does, whole or not at all."""
        write_text(Path(path), dump(self.model(), self._remark), force)

    def proposed(self) -> Scenario | None:
        """Return the recording to make next as a scenario, as ``--next-out NAME.toml`` writes it; None where none is proposed."""
        return diagnose_movements.proposed(self.document.next_experiment)

    def proposed_tensions(self) -> pd.DataFrame | None:
        """Return the tensions to drive in it, as ``--next-out NAME.csv`` writes them: ``system``, ``time_s``, ``tension_in_n``."""
        experiment, movement = self.document.next_experiment, self.proposed()
        if experiment is None or movement is None:
            return None
        return pd.read_csv(io.StringIO(diagnose_movements.tensions(movement, experiment)))

    def __repr__(self) -> str:
        named = " + ".join(self.verdict.effects)
        return f"Diagnosis({self.verdict.status}{': ' if named else ''}{named})"

    def _inputs(self, with_log: bool = False) -> Inputs:
        runs = [view(run) for run in self.log.runs] if with_log else []
        files = [("log", name, digest) for name, digest in self.log.inputs.items()] if with_log else []
        shown = read(Diagnosed, {**self.to_dict(), "file": NAME})
        return Inputs(log=runs, diagnosis=[shown], files=[*files, ("diagnosis", NAME, "")])

    def _repr_html_(self) -> str:
        buffer = io.BytesIO()
        self.plot().savefig(buffer, format="png", dpi=110)
        picture = base64.b64encode(buffer.getvalue()).decode()
        shown = self.candidates[["id", "probability", "rmse_held_out_n", "shrink_pct", "identifiability"]].head(SHOWN)
        table = shown.to_html(index=False, float_format="%.3g", na_rep="–", border=0)
        alt = html.escape(choose(self._inputs()).alt, quote=True)
        return f'<p>{html.escape(self.sentence)}</p>{table}<img alt="{alt}" src="data:image/png;base64,{picture}">'


# long: one parameter for each option of the command, each told; the body fits a screen
def diagnose(
    log: Log,
    sim: str | PathLike[str] | Scenario | None = None,
    *,
    against: Log | None = None,
    before: Log | None = None,
    effects: Iterable[str] | None = None,
    exclude: Iterable[str] = (),
    max_effects: int = 3,
    prior: Mapping[str, float] | None = None,
    position: bool = False,
    physics: bool = True,
    max_tension_n: float | None = None,
    max_rate_n_per_s: float | None = None,
    workers: int = 2,
    max_seconds: float | None = None,
) -> Diagnosis:
    """Return where the gap between a log and a simulator lies, and which effect causes it.

    Parameters
    ----------
    log : Log
        Recorded ``act`` and/or ``sstl`` runs; of more than 1000 with fewer than 16 samples only the first 1000 are looked at.
    sim : str, path or Scenario, optional
        The simulator: a scenario file or name, or the model of another diagnosis (the physical base by default).
    against : Log, optional
        Another simulator's log for the same input, with the same run ids.
    before : Log, optional
        What was recorded before a change: the model that is fitted to it is the simulator.
    effects, exclude : iterable of str
        Ids of the candidates (the whole catalogue by default), and of those that are none.
    max_effects : int
        How many effects may be combined, 1 to 3.
    prior : mapping of id to odds, optional
        Odds of effects over those of the library; no confidence is given then.
    position : bool
        Diagnose the recorded position too.
    physics : bool
        Set runs aside that cannot be right (docs/gate.md).
    max_tension_n, max_rate_n_per_s : float, optional
        What a proposed recording may ask of the input, N and N/s (as recorded by default).
    workers : int
        Threads; the answer does not depend on it.
    max_seconds : float, optional
        Begin nothing after this that can be left out; the notes of the document say what was.

    Raises
    ------
    SstlError
        If no run can be used, an effect or scenario is unknown, or odds are not positive.

    Examples
    --------
    >>> from sstl_cli.api.log import simulate
    >>> log = simulate("sample", effects=["pulley_friction:m_p=0.1,m_r=0.1"], seed=1)
    >>> diagnose(log, effects=["pulley_friction", "const_friction"], max_effects=1)
    Diagnosis(identified: pulley_friction)
    """
    given = load(str(sim)) if sim is not None and not isinstance(sim, Scenario) else sim
    options = DiagnoseOptions(
        sim=given,
        effects=None if effects is None else tuple(effects),
        exclude=tuple(exclude),
        max_effects=max_effects,
        workers=workers,
        position=position,
        prior=odds(prior or {}, "prior"),
        physics=physics,
        max_tension_n=max_tension_n,
        max_rate_n_per_s=max_rate_n_per_s,
        odd_runs=True,
        max_seconds=max_seconds,
    )
    runs = _looked_at(log)
    if against is not None:
        from sstl_cli.physics.rebased import rebase

        runs = rebase(runs, _looked_at(against))
    result = diagnose_tendons.run(runs, options, earlier=None if before is None else _looked_at(before))
    files = [Path(sim)] if sim is not None and not isinstance(sim, Scenario) and Path(sim).is_file() else []
    read = [other.inputs for other in (log, against, before) if other is not None]
    inputs = {name: digest for known in (*read, inputs_of(files)) for name, digest in known.items()}
    # as JSON holds it: what is no number is null there
    document = DiagnosisDocument.model_validate_json(dumps(result.body.model_copy(update={"inputs": inputs}).plain()))
    return Diagnosis(log, document, result.bare(), result.model, "" if result.given.trajectories else diagnose_movements.SAID)


def _looked_at(log: Log) -> list[Run]:
    """Return the runs of a log that a diagnosis looks at, as the command does; one line warns of the others."""
    with kept_apart():
        book = open_ledger()
        runs = list(few_short(log.runs))
    if book.entries:
        warnings.warn(f"set aside: {book.brief()}", stacklevel=3)
    return runs

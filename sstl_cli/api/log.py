"""Recordings in memory: read, made from tables, simulated; segmented and written."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
import pyarrow as pa

from sstl_cli.core.documents.logs import LogRun
from sstl_cli.core.errors import SstlError
from sstl_cli.core.parquet import conform
from sstl_cli.core.provenance import Provenance, inputs_of
from sstl_cli.core.run_parts import SIGNALS
from sstl_cli.core.runs import Run, read_logs, require_units_of, run_table, runs_of, write_runs
from sstl_cli.core.sound import noted
from sstl_cli.core.tables import LOG, TENDON
from sstl_cli.identification import SegmentOptions, samples
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps import info as telling
from sstl_cli.steps import judge as judging
from sstl_cli.steps import segment as segmenting
from sstl_cli.steps import simulate as simulating
from sstl_cli.steps.check import Entry

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Log", "Scenario", "read", "simulate"]

SHOWN = 20


@dataclass(frozen=True)
class Log:
    """Recorded or simulated runs.

    Attributes
    ----------
    runs : tuple of Run
        Labels and float64 arrays of each run: time in s, tensions in N, position in mm.
    inputs : dict of str to str
        SHA-256 of the files it was read from, by name.
    """

    runs: tuple[Run, ...]
    inputs: dict[str, str] = field(default_factory=dict)

    @classmethod
    def from_frame(cls, frame: pd.DataFrame) -> Log:
        """Return a log from a table with the columns of the log schema; other columns are left out.

        Raises
        ------
        SstlError
            If a required column is missing or holds something else, or a run is not contiguous.

        Examples
        --------
        >>> import numpy as np
        >>> t = np.arange(0.0, 4.0, 0.01)
        >>> pull = 10.0 + 8.0 * np.sin(2 * np.pi * 0.5 * t)
        >>> Log.from_frame(pd.DataFrame({"run_id": "r1", "system": "act", "time_s": t,
        ...                              "tension_in_n": pull, "tension_out_n": 0.7 * pull}))
        Log(1 run, 400 samples)
        """
        known = {c.name: c for c in (*LOG.columns, TENDON)}
        arrays = {}
        for name in (n for n in frame.columns if n in known):
            values = frame[name]
            # NaN in a required signal is a bad sample, in an optional one or a label it means "none"
            none = known[name].nullable or not pd.api.types.is_float_dtype(values.dtype)
            try:
                arrays[name] = pa.array(values if none else values.to_numpy(), from_pandas=none)
            except (pa.ArrowException, ValueError, TypeError) as error:
                raise SstlError(
                    f"column '{name}' holds mixed values ({error})",
                    where="DataFrame",
                    fix="give each column one kind of value",
                    code="E135",
                ) from None
        table = conform(pa.table(arrays), LOG, "DataFrame")
        return cls(tuple(piece for run in runs_of([table], "DataFrame") for piece in noted(run)))

    def frame(self) -> pd.DataFrame:
        """Return all samples as one table with the columns of the log schema."""
        tendons = any(r.tendon is not None for r in self.runs)
        tables = [run_table(r, tendons) for r in self.runs]
        frame: pd.DataFrame = (pa.concat_tables(tables) if tables else LOG.arrow().empty_table()).to_pandas()
        return frame

    def summary(self) -> pd.DataFrame:
        """Return one row a run, as ``sstl info`` tells it of a file: labels, samples, times in s, rate in Hz, ranges in N.

        Examples
        --------
        >>> simulate("two-tendons", seed=1).summary()[["run_id", "samples", "rate_hz"]].head(1).round(1).values.tolist()
        [['CP-020-0-ramp_hold-act-A', 4000, 100.0]]
        """
        rows = [telling.summary_of(r).document().model_dump() for r in self.runs if len(r)]
        return pd.DataFrame(rows, columns=list(LogRun.model_fields))

    def segment(
        self,
        *,
        cutoff_hz: float | None = None,
        prominence_n: float | None = None,
        delta_bl_n: float | None = None,
        ransac_threshold_n: float | None = None,
        ransac_trials: int = 64,
        seed: int = 0,
        physics: bool = True,
    ) -> pd.DataFrame:
        """Return the Theta table: slopes and biases of the propagation lines with standard errors, one row a run.

        What could not be identified, and what fails the physics gate, is null with the reason in ``status``, and warned of.

        Parameters
        ----------
        cutoff_hz, prominence_n, delta_bl_n, ransac_threshold_n : float, optional
            As the options of ``sstl segment``; None is derived from rate, noise and range.
        ransac_trials : int
            Pairs of points tried per direction.
        seed : int
            Seed of the sampler.
        physics : bool
            Set runs aside that cannot be right (docs/gate.md).

        Raises
        ------
        SstlError
            If there is no run, two carry the same run_id, all fail the physics gate, or a setting does not fit.

        Examples
        --------
        >>> theta = simulate("two-tendons", seed=1).segment()
        >>> theta[["run_id", "gamma_p", "gamma_r"]].head(2).round(2).values.tolist()
        [['CP-020-0-ramp_hold-act-A', 0.61, 1.63], ['CP-020-0-ramp_hold-act-B', 0.61, 1.63]]
        """
        options = SegmentOptions(cutoff_hz, prominence_n, delta_bl_n, ransac_threshold_n, ransac_trials, seed)
        rows = self._identified(options, physics).rows
        frame: pd.DataFrame = segmenting.theta_table(rows).to_pandas()
        return frame

    def phases(
        self,
        *,
        cutoff_hz: float | None = None,
        prominence_n: float | None = None,
        delta_bl_n: float | None = None,
        ransac_threshold_n: float | None = None,
        ransac_trials: int = 64,
        seed: int = 0,
        physics: bool = True,
    ) -> pd.DataFrame:
        """Return the phase PB, PP, RB or RP of every sample, as ``sstl segment --phases`` writes it; parameters as in ``segment``.

        Examples
        --------
        >>> simulate("two-tendons", seed=1).phases()["phase"].unique().tolist()
        ['PB', 'PP', 'RB', 'RP']
        """
        options = SegmentOptions(cutoff_hz, prominence_n, delta_bl_n, ransac_threshold_n, ransac_trials, seed)
        tables: list[pa.Table] = []
        self._identified(options, physics, lambda one: tables.append(one.phase_table()))
        frame: pd.DataFrame = pa.concat_tables(tables).to_pandas()
        return frame

    def _identified(
        self, options: SegmentOptions, physics: bool, each: Callable[[segmenting.Segmented], None] = lambda _: None
    ) -> segmenting.Identified:
        """Return what was found in every run, and warn of what was set aside; called by a method that the user calls."""
        found = segmenting.identify(self.runs, options, physics, each, "Log")
        if found.aside:
            told = f"{len(found.aside)} of {len(found.rows)} runs in part or whole (null in the table, see status)"
            warnings.warn(f"set aside: {told}", stacklevel=3)
        return found

    def check(self, physics: bool = True) -> pd.DataFrame:
        """Return what is wrong with the samples (failure) or worth knowing (remark), as ``sstl check`` tells it of a file.

        What no recorder can have measured was set aside when the log was read, and is told there.

        Parameters
        ----------
        physics : bool
            Judge by physics, too: labels, units, signs and channels that cannot be right.

        Examples
        --------
        >>> simulate("two-tendons", seed=1).check().query("level == 'failure'").empty
        True
        """
        optional = tuple(c.name for c in LOG.columns if c.nullable)
        pieces = [samples.Piece(r.run_id, {n: x for n in SIGNALS if (x := getattr(r, n)) is not None}) for r in self.runs]
        found = [Entry(f, p.run_id).of("log") for p in pieces for f in samples.findings(p, optional)]
        if physics:
            found += judging.findings(judging.run(("log", r) for r in self.runs))
        columns = ["level", "run_id", "column", "what", "count", "detail", "fix"]
        return pd.DataFrame([{c: getattr(f, c) for c in columns} for f in found], columns=columns)

    def plot(self, kind: str | None = None, run_id: str | None = None) -> Figure:
        """Return a figure of the runs, or of the one named: another ``kind`` of ``sstl plot`` than the usual one.

        Raises
        ------
        SstlError
            If there is no such figure or run, or a log holds nothing for it.
        """
        from sstl_cli.reporting import drawing
        from sstl_cli.reporting.inputs import Inputs, view
        from sstl_cli.steps.plot import run as choose

        choice = choose(Inputs(log=[view(run) for run in self.runs], files=[("log", "Log", "")]), kind, run_id)
        return drawing.drawn(choice.module, choice.data, choice.title)

    def write(self, path: str | PathLike[str], force: bool = False) -> None:
        """Write the log as Parquet, whole or not at all.

        Raises
        ------
        SstlError
            If there is no run, or the file exists and ``force`` is not given.
        """
        tendons = any(r.tendon is not None for r in self.runs)
        write_runs(Path(path), self.runs, Provenance("python", None, self.inputs), force, lambda: tendons)

    def export(self, path: str | PathLike[str], force: bool = False) -> None:
        """Write the log for other programs, by the ending of the file: ``.csv``, ``.mat`` (MATLAB, version 5) or ``.mcap``.

        Raises
        ------
        SstlError
            For another ending, no run, runs in other units than the first, one that does not fit the format, or a file that is there
            without ``force``.
        """
        from sstl_cli.steps import export_log

        out = Path(path)
        if not self.runs:
            raise SstlError("no run to write", where=str(out), fix="check the input for usable samples", code="E120")
        first = self.runs[0]
        for run in self.runs:
            require_units_of(run, first, out)
        about = export_log.About.of(
            {"unit_in": first.unit_in, "unit_out": first.unit_out}, any(r.tendon is not None for r in self.runs), "log"
        )
        export_log.write(self.runs, about, out, out.suffix[1:].lower(), force)

    def __len__(self) -> int:
        return len(self.runs)

    def __repr__(self) -> str:
        samples = sum(map(len, self.runs))
        return f"Log({len(self)} run{'s' if len(self) != 1 else ''}, {samples} samples)"

    def _repr_html_(self) -> str:
        rows = [
            {
                "run": r.run_id, "system": r.system, "configuration": r.config_id, "trajectory": r.trajectory,
                "samples": len(r), "duration / s": float(r.time_s[-1] - r.time_s[0]) if len(r) else 0.0,
            }
            for r in self.runs[:SHOWN]
        ]  # fmt: skip
        more = f"<p>and {len(self) - SHOWN} more</p>" if len(self) > SHOWN else ""
        table: str = pd.DataFrame(rows).to_html(index=False, float_format="%.4g", na_rep="–", border=0)
        return table + more


def read(*paths: str | PathLike[str]) -> Log:
    """Return the runs of one or several logs (Parquet), in the order given.

    Raises
    ------
    SstlError
        If a file is missing, no log, or two of them hold the same run.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     simulate("two-tendons", seed=1).write(Path(folder, "log.parquet"))
    ...     read(Path(folder, "log.parquet"))
    Log(12 runs, 48000 samples)
    """
    files = [Path(p) for p in paths]
    runs = tuple(read_logs(files))
    seen: set[str] = set()
    for run in runs:
        if run.run_id in seen:
            raise SstlError("comes twice", where=f"run {run.run_id!r}", fix="give every run its own run_id", code="E220")
        seen.add(run.run_id)
    return Log(runs, inputs_of(files))


def simulate(
    scenario: str | PathLike[str] | Scenario = "default",
    *,
    effects: Mapping[str, Mapping[str, float]] | Sequence[str] = (),
    simulator: str | None = None,
    noise_n: float | None = None,
    seed: int = 0,
) -> Log:
    """Return the recordings that a scenario describes.

    Parameters
    ----------
    scenario : str, path or Scenario
        A built-in name, a TOML file, or the model of a diagnosis.
    effects : mapping of id to parameters, or list of str
        Effects to add, as ``{"pulley_friction": {"m_p": 0.1}}`` or ``["pulley_friction:m_p=0.1"]``.
    simulator : str, optional
        Fast model (``transmission``) or one of the rigs; as in the scenario by default.
    noise_n : float, optional
        White noise of each tension sensor in N.
    seed : int
        Seed of the random numbers.

    Raises
    ------
    SstlError
        For an unknown scenario, effect or parameter, or a value outside its range.

    Examples
    --------
    >>> simulate("two-tendons", effects=["pulley_friction:m_p=0.1"], seed=1)
    Log(12 runs, 48000 samples)
    """
    loaded = scenario if isinstance(scenario, Scenario) else load(str(scenario))
    added = effects if isinstance(effects, Mapping) else list(effects)
    return Log(
        tuple(simulating.run(simulating.adjusted(loaded, simulator, noise_n), simulating.effects_of(added), seed)),
        inputs_of([Path(str(scenario))]) if not isinstance(scenario, Scenario) and Path(str(scenario)).is_file() else {},
    )

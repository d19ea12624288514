"""The withheld-effect check from Python: sets of cases, recordings of a real rig, and the libraries that the verdict is learned from."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from sstl_cli.api.log import Log
from sstl_cli.blind.folder import Folder, read_plan
from sstl_cli.blind.strength import STRENGTHS
from sstl_cli.core.documents.blind import (
    BlindLearnDocument,
    BlindLibraryDocument,
    BlindLimitDocument,
    BlindMakeDocument,
    BlindRunDocument,
    BlindScoreDocument,
)
from sstl_cli.core.documents.blind_real import BlindInjectDocument, BlindRealDocument
from sstl_cli.core.files import require_writable, write_json
from sstl_cli.core.provenance import inputs_of
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario, load
from sstl_cli.steps import blind_inject as injecting
from sstl_cli.steps import blind_learn as learning
from sstl_cli.steps import blind_library as collecting
from sstl_cli.steps import blind_real as returning
from sstl_cli.steps import blind_set as checking

__all__ = [
    "BlindInjectDocument", "BlindLearnDocument", "BlindLibraryDocument", "BlindLimitDocument", "BlindMakeDocument", "BlindRealDocument",
    "BlindRunDocument", "BlindScoreDocument", "BlindSet", "blind_inject", "blind_learn", "blind_library", "blind_real",
]  # fmt: skip


@dataclass(frozen=True)
class BlindSet:
    """The set of a withheld-effect check in a folder: made, diagnosed case by case, and scored against its sealed truth.

    With several ``workers`` a script needs ``if __name__ == "__main__":`` around its calls, as processes of their own do the work.

    Attributes
    ----------
    path : str or path
        The folder.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     check = BlindSet(Path(folder, "set"))
    ...     made = check.make(cases=1, quick=True, simulator="rig", seed=3, workers=1)
    ...     check.cases, made.samples
    (['case-0001'], 15832)
    """

    path: str | PathLike[str]

    @property
    def _folder(self) -> Folder:
        return Folder(Path(self.path))

    @property
    def cases(self) -> list[str]:
        """The neutral names of its cases."""
        return list(read_plan(self._folder))

    def make(
        self,
        *,
        cases: int | None = None,
        nulls: int = 0,
        quick: bool = False,
        simulator: str = "mixed",
        recordings: str = "mixed",
        workers: int = 2,
        seed: int | None = None,
        force: bool = False,
    ) -> BlindMakeDocument:
        """Draw cases from simulators that stand in for hardware, and seal what was withheld, as ``sstl blind make`` does.

        Parameters
        ----------
        cases : int, optional
            How many; by default 150, or 12 that are quick.
        nulls : int
            Further cases in which nothing is missing.
        quick : bool
            Short recordings.
        simulator : str
            rig, bristle, variant, or mixed: all in turn.
        recordings : str
            plain (complete, at a steady rate), lab (rates, gaps, held sensors), or mixed: in turn.
        workers : int
            Processes; the cases do not depend on it.
        seed : int, optional
            By default one that nobody knows, kept under the seal.
        force : bool
            Replace the set that the folder holds.

        Raises
        ------
        SstlError
            If the folder holds something, or there is no such simulator.
        """
        asked = checking.Making(cases, nulls, quick, simulator, recordings, seed)
        return checking.make(self._folder, asked, workers, force)

    def run(self, *, workers: int = 2, force: bool = False) -> BlindRunDocument:
        """Diagnose every case that has no result (with ``force`` all) from its recordings alone, as ``sstl blind run`` does.

        What was stopped goes on where it stopped.
        """
        return checking.diagnose(self._folder, read_plan(self._folder), workers, force)

    def limit(self, *, workers: int = 2, force: bool = False) -> BlindLimitDocument:
        """Measure how far each truth is from the base and from its nearest rival, as ``sstl blind limit`` does.

        Raises
        ------
        SstlError
            While a case has no result: the truth stays closed.
        """
        return checking.limit(self._folder, read_plan(self._folder), workers, force)

    def score(self, *, realised: bool = True) -> BlindScoreDocument:
        """Check the seals, open the truth, and return how well the diagnosis did, as ``sstl blind score`` does.

        Cases without a result warn.

        Parameters
        ----------
        realised : bool
            Apply accepted models to recordings that nobody diagnosed.

        Raises
        ------
        SstlError
            Without any result, or if a seal does not hold.
        """
        found = checking.score(self._folder, checking.opened(self._folder), realised)
        if found.missing_results:
            warnings.warn(f"set aside: {found.missing_results} cases without a result", stacklevel=2)
        return found


def blind_real(
    log: Log,
    *,
    model: str | PathLike[str] | Scenario | None = None,
    plant: Sequence[str] | None = None,
    strength: float = 2.0,
    seed: int = 0,
) -> BlindRealDocument:
    """Take terms out of the accepted model of recordings, one at a time, and diagnose them back, as ``sstl blind real`` does.

    Parameters
    ----------
    model : str, path or Scenario, optional
        The accepted simulator; by default the one that diagnosing the log gives.
    plant : sequence of str, optional
        Effects to add and take out again; by default a few where the model holds none.
    strength : float
        Their gap over the RMS of the residual.
    seed : int
        Seed of the random numbers.

    Raises
    ------
    SstlError
        If no run can be used, or there is no term to take out.

    Examples
    --------
    A minute:

    >>> blind_real(Log(simulate("sample").runs[:2]), plant=["zero_offset"]).named  # doctest: +SKIP
    1
    """
    known = load(str(model)) if model is not None and not isinstance(model, Scenario) else model
    terms = None if plant is None else [get(e).id for e in plant]
    found = returning.run(log.runs, known, terms, strength, seed)
    files = [Path(str(model))] if model is not None and known is not model and Path(str(model)).is_file() else []
    return found.model_copy(update={"inputs": {**log.inputs, **inputs_of(files)}})


def blind_inject(logs: Mapping[str, Log], sizes: Mapping[str, float] | None = None) -> BlindInjectDocument:
    """Put effects into the second half of each log and diagnose them, as ``sstl blind real --inject`` does.

    Parameters
    ----------
    logs : mapping of name to Log
        Recordings of real rigs, two runs or more each.
    sizes : mapping of effect to size, optional
        What is put in; by default every effect that can be put into tensions, at 7 % of the span.

    Examples
    --------
    Minutes:

    >>> blind_inject({"bench": simulate("sample")}, {"zero_offset": 1.0}).with_model.named  # doctest: +SKIP
    1
    """
    found = injecting.run({name: log.runs for name, log in logs.items()}, sizes)
    return found.model_copy(update={"inputs": {n: h for log in logs.values() for n, h in log.inputs.items()}})


def blind_library(
    path: str | PathLike[str],
    *,
    cases: int,
    simulator: str = "mixed",
    recordings: str = "mixed",
    strength: Sequence[float] | None = None,
    accepted: bool = False,
    habits: bool = False,
    quick: bool = False,
    workers: int = 2,
    seed: int = 0,
    force: bool = False,
) -> BlindLibraryDocument:
    """Draw cases and write the evidence that a verdict is made from, as ``sstl blind library`` does; goes on where it was stopped.

    Parameters
    ----------
    path : str or path
        The library (Parquet).
    cases, simulator, recordings, quick, workers, seed
        As of ``BlindSet.make``.
    strength : sequence of float, optional
        Gaps over the noise; by default 0.4, 1.2 and 4.
    accepted : bool
        Ask what has changed since a session whose model was accepted.
    habits : bool
        Of rigs that do what no law describes, too.
    force : bool
        Replace the file.

    Raises
    ------
    SstlError
        If the file exists, its parts belong to another library, or there is no such simulator.

    Examples
    --------
    Hours:

    >>> blind_library("library.parquet", cases=600, quick=True).rows  # doctest: +SKIP
    """
    asked = collecting.Options(cases, seed, simulator, quick, recordings, tuple(strength or STRENGTHS), accepted, habits)
    return collecting.run(Path(path), asked, workers, force)


def blind_learn(*libraries: str | PathLike[str], out: str | PathLike[str], force: bool = False) -> BlindLearnDocument:
    """Learn the verdict's weights from libraries and write them, as ``sstl blind learn`` does; says how they do on simulators left out.

    Parameters
    ----------
    libraries : str or path
        Libraries (Parquet) of ``blind_library``.
    out : str or path
        The weights (JSON).
    force : bool
        Replace the file.

    Raises
    ------
    SstlError
        If a file is no library, or all of them together hold too few cases or one simulator only.

    Examples
    --------
    >>> blind_learn("library.parquet", out="weights.json").commit  # doctest: +SKIP
    """
    place = Path(out)
    require_writable(place, force)
    weights, document = learning.run([Path(p) for p in libraries], str(place))
    write_json(place, weights, force)
    return document

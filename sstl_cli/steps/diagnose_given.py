"""What the document of a diagnosis is made from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.documents.gate import Remark
from sstl_cli.diagnosis import following
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.features import Ids
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.gathering import Evidence
from sstl_cli.diagnosis.verdict import Verdict

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Given(Evidence):
    """Everything that a document is made from: the evidence, and what is said of it.

    ``passed`` says whether a stage that can be left out has to be, ``shows_d2`` is that of the weights.
    """

    verdict: Verdict
    accepted: Fit
    remarks: Sequence[Remark] = ()
    limits: following.Limits | None = None
    passed: Callable[[str], bool] = lambda _: False
    shows_d2: float = DECIDABLE


@dataclass(frozen=True)
class Errors:
    """Held-out residuals of base and accepted model (N), and the white noise above the analysis rate (N)."""

    base: Array
    accepted: Array
    fine_n: float
    weight: Array
    known: Array

    def rms(self, residual: Array) -> float:
        """Return the RMS (N) of a residual at the full rate."""
        squared = np.sum(self.weight * residual**2) / max(float(self.weight.sum()), 1.0)
        return float(np.sqrt(squared + self.fine_n**2))


def name(ids: Ids) -> str:
    """Return the name of a model in documents: its effects joined by a plus."""
    return "+".join(ids)

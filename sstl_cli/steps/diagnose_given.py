"""What the document of a diagnosis is made from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from sstl_cli.core.documents.gate import Remark
from sstl_cli.diagnosis import following
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.diagnosis.features import Ids
from sstl_cli.diagnosis.judged import Judged


@dataclass(frozen=True, kw_only=True)
class Given(Judged):
    """Everything that a document is made from: the evidence, what is said of it, and what was asked.

    ``passed`` says whether a stage that can be left out has to be, ``shows_d2`` is that of the weights.
    """

    remarks: Sequence[Remark] = ()
    limits: following.Limits | None = None
    passed: Callable[[str], bool] = lambda _: False
    shows_d2: float = DECIDABLE


def name(ids: Ids) -> str:
    """Return the name of a model in documents: its effects joined by a plus."""
    return "+".join(ids)

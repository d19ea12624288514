"""The gate judges the same runs in many tests: it measures them once."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from sstl_cli.identification import gate
from tests import known_runs


@pytest.fixture(scope="module", autouse=True)
def measured_once() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gate, "evidence_of", known_runs.evidence_of)
        yield

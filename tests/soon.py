"""Parameters of a test that every run of the suite asks, and those that are left to the slow one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def asked(values: Iterable[Any], *now: Any, several: bool = False) -> list[Any]:
    """Return what a test is asked, ``several`` arguments at a time or one; what is not among ``now`` is slow."""
    return [v if v in now else pytest.param(*(v if several else (v,)), marks=pytest.mark.slow) for v in values]

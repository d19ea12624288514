"""Two hundred damaged recordings for every importer (long runs: fuzz_importers.py as a script)."""

from __future__ import annotations

import pytest
from fuzz_importers import fuzz_one, mutated
from seeds import WRITERS

INPUTS = 200


@pytest.mark.parametrize("name", WRITERS)
def test_damaged_recordings_end_in_runs_or_one_error(name: str) -> None:
    for number in range(INPUTS):
        fuzz_one(name, mutated(name, number))


def test_mutations_are_repeatable_and_different() -> None:
    assert mutated("text", 3) == mutated("text", 3)
    assert len({mutated("text", i) for i in range(50)}) > 45

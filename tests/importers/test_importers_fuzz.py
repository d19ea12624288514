"""Damaged recordings for every importer, two hundred for most (long runs: fuzz_importers.py as a script)."""

from __future__ import annotations

import pytest
from fuzz_importers import fuzz_one, mutated
from seeds import WRITERS

INPUTS = 200
# HDF5 is read in a process of its own, each of which costs a tenth of a second
FEWER = {"hdf5": 24, "mat73": 24}


@pytest.mark.parametrize("name", WRITERS)
def test_damaged_recordings_end_in_runs_or_one_error(name: str) -> None:
    for number in range(FEWER.get(name, INPUTS)):
        fuzz_one(name, mutated(name, number))


@pytest.mark.slow
@pytest.mark.parametrize("name", FEWER)
def test_the_rest_of_two_hundred(name: str) -> None:
    for number in range(FEWER[name], INPUTS):
        fuzz_one(name, mutated(name, number))


def test_mutations_are_repeatable_and_different() -> None:
    assert mutated("text", 3) == mutated("text", 3)
    assert len({mutated("text", i) for i in range(50)}) > 45

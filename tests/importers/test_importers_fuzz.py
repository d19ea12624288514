"""Damaged recordings for every importer: the first of two hundred (all of them with ``-m slow``; long runs: fuzz_importers.py as a script)."""

from __future__ import annotations

import pytest
from fuzz_importers import fuzz_one, mutated
from seeds import WRITERS

INPUTS = 200
# what every run of the suite tries; HDF5 is read in a process of its own, each of which costs a tenth of a second
FIRST = dict.fromkeys(WRITERS, 80) | {"hdf5": 12, "mat73": 12}


@pytest.mark.parametrize("name", WRITERS)
def test_damaged_recordings_end_in_runs_or_one_error(name: str) -> None:
    for number in range(FIRST[name]):
        fuzz_one(name, mutated(name, number))


@pytest.mark.slow
@pytest.mark.parametrize("name", WRITERS)
def test_the_rest_of_two_hundred(name: str) -> None:
    for number in range(FIRST[name], INPUTS):
        fuzz_one(name, mutated(name, number))


def test_mutations_are_repeatable_and_different() -> None:
    assert mutated("text", 3) == mutated("text", 3)
    assert len({mutated("text", i) for i in range(50)}) > 45

"""A short run of the fuzzer over every file the program reads back (long runs: ``make fuzz``)."""

from __future__ import annotations

import json

import pytest
from fuzz_mutations import mutated
from fuzz_readers import READERS, at_most, fuzz
from fuzz_seeds import seed_of
from soon import asked

# those that make a page or run a command for each input are slower
COUNTS = {"diagnosis": 15, "config": 60}
MOST = 250
# what every run of the suite tries of each kind
FIRST = {kind: min(2 * COUNTS.get(kind, MOST) // 5, 100) for kind in sorted(READERS)}
EVERY = [*FIRST.items(), *((kind, COUNTS.get(kind, MOST)) for kind in FIRST)]


@pytest.mark.parametrize(("kind", "count"), asked(EVERY, *FIRST.items(), several=True))
def test_damaged_files(kind: str, count: int) -> None:
    found = fuzz(kind, count)
    assert found.inputs == count
    # a fuzzer whose every input is refused at the first byte tests nothing
    assert found.read > 0 and found.refused > count // 20, found


@pytest.mark.parametrize("kind", sorted(READERS))
def test_undamaged_files_are_read(kind: str, tmp_path) -> None:  # type: ignore[no-untyped-def]
    suffix, read = READERS[kind]
    path = tmp_path / f"good{suffix}"
    path.write_bytes(seed_of(kind))
    read(path)


def test_mutations_are_repeatable_and_different() -> None:
    assert mutated("theta", 4) == mutated("theta", 4)
    assert len({mutated("controller", i) for i in range(60)}) > 50


def test_half_of_the_mutations_are_well_formed() -> None:
    for number in range(0, 40, 2):
        json.loads(mutated("controller", number))


def test_a_hang_is_found() -> None:
    with pytest.raises(AssertionError, match="hangs"), at_most(1, "a loop"):
        while True:
            pass

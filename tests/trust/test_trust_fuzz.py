"""A short run of the fuzzer over every file the program reads back."""

from __future__ import annotations

import pytest
from fuzz_readers import READERS, fuzz

COUNTS = {"log": 350, "theta": 350, "model": 350}


@pytest.mark.parametrize("kind", sorted(READERS))
def test_mutated_files(kind: str) -> None:
    count = COUNTS.get(kind, 350)
    found = fuzz(kind, count)
    # a fuzzer whose every input is refused at the first byte tests nothing
    assert found["read"] > 0 and found["refused"] > count // 20, found

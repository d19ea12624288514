"""An output that only rattles in its hold propagates nothing; one that leaves it in any run does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from sstl_cli.diagnosis.propagation import propagates


@dataclass
class Read:
    y: np.ndarray

    def __len__(self) -> int:
        return len(self.y)


@dataclass
class Given:
    records: list[Read]


NOISE = np.random.default_rng(1).normal(0.0, 0.02, 400)
SLOW = np.sin(np.linspace(0.0, 6.0, 400))


@pytest.mark.parametrize(
    ("outputs", "expected"),
    [
        ([NOISE], False),
        ([5.0 + 0.001 * SLOW + NOISE], False),
        ([5.0 + SLOW + NOISE], True),
        ([NOISE, 5.0 + SLOW + NOISE], True),
        ([np.full(400, 5.0)], False),
        # too short to tell, whatever it does
        ([5.0 + SLOW[:20]], False),
    ],
)
def test_what_leaves_its_hold_propagates(outputs: list[np.ndarray], expected: bool) -> None:
    assert propagates(Given([Read(y) for y in outputs])) is expected

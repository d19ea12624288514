"""Small laws of the identification: block lengths worked by hand, limits that must fall and rise."""

from __future__ import annotations

import numpy as np
import pytest

from sstl_cli.identification.change import LEARN, LIMITS, LOOPS, limit
from sstl_cli.identification.lines import block_length, ransac


@pytest.mark.parametrize(
    ("samples", "dt_s", "length"),
    [(100, 0.001, 10), (100, 0.01, 1), (100, 0.5, 1), (4096, 1.0, 1), (4097, 1.0, 2), (1_000_000, 0.01, 245)],
)
def test_blocks_of_ten_ms_and_at_most_4096(samples: int, dt_s: float, length: int) -> None:
    assert block_length(samples, dt_s) == length


def test_limits_fall_with_learning_and_rise_with_loops() -> None:
    assert LIMITS.shape == (len(LEARN), len(LOOPS))
    assert (np.diff(LIMITS, axis=0) < 0).all() and (np.diff(LIMITS, axis=1) > 0).all()
    # no jump: neighbours in a row differ by less than half, as a simulation leaves them
    assert (LIMITS[:, 1:] / LIMITS[:, :-1]).max() < 1.4 and (LIMITS[:-1] / LIMITS[1:]).max() < 1.5


def test_limit_of_numbers_in_the_table_and_beyond() -> None:
    assert limit(20, 500) == pytest.approx(8.0)
    assert limit(10, 50) == limit(5, 10) == pytest.approx(6.1)
    assert limit(100, 5000) == limit(1000, 1e6) == pytest.approx(6.3)


def test_ransac_leaves_outliers_out() -> None:
    rng = np.random.default_rng(0)
    x = np.linspace(5.0, 30.0, 400)
    y = 0.6 * x + 0.3 + rng.normal(0, 0.01, 400)
    y[::5] += 4.0
    slope, bias, threshold = ransac(x, y, 1.0, 0.001, False, 64, rng)
    assert slope == pytest.approx(0.6, abs=2e-3) and bias == pytest.approx(0.3, abs=0.05)
    # four robust standard deviations; the outliers make the median a little larger
    assert 0.03 < threshold < 0.07
    assert ransac(x, y, 1.0, 0.001, True, 64, rng)[2] == 1.0
    assert ransac(x, y, 1.0, 0.5, False, 64, rng)[2] == 0.5

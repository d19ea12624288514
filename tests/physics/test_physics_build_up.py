"""Friction that builds up ever more slowly: its closed form, its slopes, and the laws of other simulators that it follows."""

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from sstl_cli.physics.transmission.build_up import built_up
from sstl_cli.physics.transmission.lanes import put, row, rows

TAILS = (0.0, 0.3, 1.0)


@njit(error_model="numpy")
def _built_up(given, found):
    force, stays, follows = built_up(
        row(given, 0), row(given, 1), row(given, 2), row(given, 3), row(given, 4), row(given, 5), row(given, 6), row(given, 7)
    )
    put(found, 0, force)
    put(found, 1, stays)
    put(found, 2, follows)


def friction(way, force_old=-0.4, tension=10.0, tail=1.0, towards=0):
    """Force and slopes at a node whose limits are a tenth (pulling) and an eighth (releasing) of the tension before it."""
    given = rows(8)
    given[:, :] = np.array([[way], [towards], [force_old], [-0.125 * tension - 0.2], [0.1 * tension + 0.2], [0.1], [0.125], [tail]])
    found = rows(3)
    _built_up(given, found)
    # lanes that are given alike answer alike
    assert (found == found[:, :1]).all()
    return tuple(found[:, 0].tolist())


@pytest.mark.parametrize("tail", TAILS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_is_missing_falls_as_its_law_says(tail, sign):
    limit = 1.2 if sign > 0.0 else -1.45
    # the law of the source, integrated: dF/dx = L ((1 - s) g^(1/2) + s g), g = 1 - F/L

    def rate(_, f):
        g = np.maximum(1.0 - f / limit, 0.0)
        return limit * ((1.0 - tail) * np.sqrt(g) + tail * g)

    ways = np.array([0.05, 0.4, 1.0, 1.7])
    law = solve_ivp(rate, (0.0, 2.0), [-0.4], t_eval=ways, rtol=1e-9, atol=1e-11).y[0]
    assert [friction(sign * x, tail=tail)[0] for x in ways] == pytest.approx(law, abs=1e-6)


def test_the_law_without_a_tail_ends_and_dahls_does_not():
    assert friction(4.0, tail=0.0)[:2] == (pytest.approx(1.2), 0.0)
    force, slope, _ = friction(4.0, tail=1.0)
    assert force == pytest.approx(1.2 - 1.6 * np.exp(-4.0)) and slope == pytest.approx(1.6 * np.exp(-4.0))


@pytest.mark.parametrize("tail", TAILS)
@pytest.mark.parametrize(("way", "force_old"), [(0.6, -0.4), (-0.6, -0.4), (0.3, 1.5), (-0.3, 1.5), (0.3, -1.9)])
def test_slopes_are_those_of_the_force(tail, way, force_old):
    _, stays, follows = friction(way, force_old, tail=tail)
    h = 1e-6
    ahead, behind = (friction(way + d, force_old, tail=tail)[0] for d in (h, -h))
    assert stays == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-6)
    ahead, behind = (friction(way, force_old, 10.0 + d, tail)[0] for d in (h, -h))
    assert follows == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-6)


def test_at_rest_the_next_way_is_that_of_the_last_step_or_the_steeper_one():
    up, down = friction(0.0, towards=1)[1], friction(0.0, towards=-1)[1]
    assert up == pytest.approx(1.6) and down == pytest.approx(1.05)
    assert friction(0.0, towards=0) == (-0.4, pytest.approx(1.6), 0.0)
    # beyond its limit friction has slipped, and goes with it
    assert friction(0.0, 1.5, towards=1) == (pytest.approx(1.2), 0.0, pytest.approx(0.1))

"""Thinning keeps what the eye looks for."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sstl_cli.reporting.reduce import keep


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(200, 5000), st.integers(5, 40))
def test_extremes_ends_and_size(seed, n, stretches):
    rng = np.random.default_rng(seed)
    channels = [rng.normal(size=n).cumsum(), rng.normal(size=n)]
    index = keep(channels, stretches)
    assert np.all(np.diff(index) > 0) and index[0] == 0 and index[-1] == n - 1
    assert len(index) <= max(stretches * 7 + 1, 1)
    for channel in channels:
        assert channel[index].min() == channel.min() and channel[index].max() == channel.max()


def test_corner_inside_a_stretch_survives():
    # monotone with a kink at 137: not an extreme of any stretch, but the corner of the loop
    x = np.arange(1000.0)
    y = np.where(x < 137, 5 * x, 5 * 137 + 0.1 * (x - 137))
    assert 137 in keep([x, y], 20)


def test_missing_samples_do_not_hide_extremes():
    y = np.sin(np.arange(2000) / 100)
    y[500:520] = np.nan
    index = keep([y], 10)
    assert np.nanmax(y[index]) == np.nanmax(y) and np.nanmin(y[index]) == np.nanmin(y)

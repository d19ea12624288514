"""The offline replay does to the last bit what the step does sample by sample."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sstl_cli.control.controller import Controller, Options, Theta

THETA = Theta(0.583, -1.444, 1.688, -1.043)


def _signals(seed: int, faults: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a wandering reference with flats and tiny turns, its tension, and lost or wild samples."""
    rng = np.random.default_rng(seed)
    steps = rng.choice([0.0, 0.0, 0.4, 0.4, 0.4, -0.4, 1e-3, -1e-3], 600)
    reference = np.clip(12.0 + np.cumsum(np.repeat(steps, 3) * rng.choice([1.0, -1.0], 1800)), 0.0, 40.0)
    tension = np.clip(reference / 0.583 + rng.normal(0.0, 3.0, reference.size), 0.0, 90.0)
    for signal in (reference, tension):
        for at in rng.integers(0, reference.size, faults):
            signal[at : at + rng.integers(1, 90)] = rng.choice([np.nan, np.inf, -50.0, 500.0])
    return reference, tension


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 10_000),
    st.integers(0, 4),
    st.booleans(),
    st.sampled_from([0.0, 0.3]),
    st.sampled_from([{}, {"lead_s": 0.02}, {"max_rate_n_s": 40.0}, {"reversal": "play"}]),
)
def test_replay_is_the_step(seed: int, faults: int, doubled: bool, deadband: float, more: dict[str, object]) -> None:
    options = Options(doubled=doubled, deadband_n=deadband, **more)
    reference, tension = _signals(seed, faults)
    one, other = Controller(THETA, options), Controller(THETA, options)
    command, phase = one.replay(reference, tension)
    single = [other.step(float(a), float(b)) for a, b in zip(reference, tension, strict=True)]
    np.testing.assert_array_equal(command, [c for c, _ in single])
    assert [("PB", "PP", "RB", "RP", "SAFE")[p] for p in phase] == [p for _, p in single]
    np.testing.assert_array_equal(one.state, other.state)


@pytest.mark.parametrize("cut", [1, 7, 500])
def test_a_replay_in_two_pieces_is_the_whole(cut: int) -> None:
    reference, tension = _signals(3, 2)
    whole, pieces = Controller(THETA), Controller(THETA)
    expected = whole.replay(reference, tension)[0]
    got = [pieces.replay(reference[part], tension[part])[0] for part in (slice(0, cut), slice(cut, None))]
    np.testing.assert_array_equal(np.concatenate(got), expected)

"""Mixtures and windows of the evidence for rests, against plain numpy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from sstl_cli.diagnosis import sticking


def likeliest(columns):
    share = np.full(columns.shape[1], 1.0 / columns.shape[1])
    for _ in range(200):
        post = columns * share
        share = (post / post.sum(axis=1, keepdims=True)).mean(axis=0)
    return float(np.log(columns @ share).sum())


def evidence(ratio, error):
    """Return by how much a share at nothing makes ratios likelier beside any even scatter about one, or about their mean."""
    widths, with_rests, without = np.median(error) * 2.0 ** (0.5 * np.arange(14)), [], []
    rest = np.maximum(norm.pdf(ratio, 0.0, error), 1e-300)
    for about in (1.0, ratio.mean()):
        off = ratio - about
        columns = [np.maximum(norm.pdf(off, 0.0, error), 1e-300)]
        columns += [np.maximum((norm.cdf((off + w) / error) - norm.cdf((off - w) / error)) / (2.0 * w), 1e-300) for w in widths]
        without.append(likeliest(np.column_stack(columns)))
        with_rests.append(likeliest(np.column_stack([*columns, rest])))
    return max(max(with_rests) - max(without), 0.0)


@pytest.mark.parametrize(("rests", "about", "spread"), [(0.0, 1.0, 0.1), (0.3, 1.0, 0.1), (0.5, 1.4, 0.4), (0.2, 0.8, 0.02)])
def test_evidence_is_that_of_the_likeliest_mixtures(rests, about, spread):
    rng = np.random.default_rng(2)
    error = 0.05 * rng.uniform(0.5, 2.0, 60)
    true = np.where(rng.random(60) < rests, 0.0, about + spread * rng.standard_normal(60))
    ratio = true + error * rng.standard_normal(60)
    assert sticking._spike(ratio, error) == pytest.approx(evidence(ratio, error), rel=1e-6, abs=1e-6)


def test_windows_are_as_long_as_the_model_has_come_far_enough():
    # a model of a newton a sample, up ten and down ten; an error of 0.5 N six times over are three samples
    model = np.concatenate((np.arange(11.0), 9.0 - np.arange(10.0)))
    output = np.where(np.arange(21) < 11, 0.8 * model, 8.0 - 0.5 * (10.0 - model))
    ratio, error = sticking._windows(output, model, np.ones(21, bool), 0.5, 6.0)
    assert ratio == pytest.approx([0.8] * 3) and error == pytest.approx([0.5 / 3.0] * 3)
    # where it moves by more than half of what is due in both strokes both count
    follows = np.where(np.arange(21) < 11, 0.8 * model, 8.0 - 0.6 * (10.0 - model))
    assert sticking._windows(follows, model, np.ones(21, bool), 0.5, 6.0)[0] == pytest.approx([0.8] * 3 + [0.6] * 3)
    # rests between movements count, those before the first and behind the last do not
    jumps = np.array([0.0] * 4 + [3.0] * 3 + [3.0] * 3 + [9.0] * 3 + [9.0] * 5)
    ratio, _ = sticking._windows(jumps, np.arange(18.0), np.ones(18, bool), 0.5, 6.0)
    assert ratio == pytest.approx([1.0, 0.0, 2.0])
    # a masked sample ends a stroke
    good = np.arange(21) != 5
    assert sticking._windows(0.8 * model, model, good, 0.5, 6.0)[0] == pytest.approx([0.8] * 5)

"""Friction that falls with speed where the line jumps at moments that nobody knows."""

import numpy as np
import pytest
from soon import asked

from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.gathering import gather
from sstl_cli.diagnosis.question import Question
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.jumps import weakening
from sstl_cli.physics.transmission.model import drive_of

T = np.arange(0.0, 60.0, 0.02)
# the family, and what comes nearest to it in the whole catalogue: of friction, of speed, of time and of the sensor
LIKE = ("stick_slip", "stribeck", "dwell_aging", "viscous", "const_friction", "presliding", "channel_lowpass")


def test_the_mean_law_is_the_effect_at_rest_and_nothing_at_speed():
    assert weakening(1.0, 1.0) == []
    # 2.5 and 250 N/s on 0.25 mm/N of line and load: 0.625 and 62.5 mm/s
    path = np.concatenate((np.zeros(50), np.arange(50) * 0.05, 2.5 + np.arange(50) * 5.0))
    (scale,) = weakening(1.3, 2.0)
    factor = scale(drive_of("act", None, 0.02, path, Mechanics()))
    assert factor[10] == pytest.approx(1.3) and factor[75] == pytest.approx(1.0 + 0.3 * np.exp(-((0.625 / 2.0) ** 2)), rel=1e-3)
    assert factor[130] == pytest.approx(1.0)


def jumping(seed):
    """Return a run whose line loses 4 % more while it is pulled slowly, in jumps at random moments, and holds what the last one left."""
    rng = np.random.default_rng(seed)
    times = np.concatenate(([0.0], np.cumsum(np.where(np.arange(24) % 4 < 2, 3.5, 1.2))))
    u = np.interp(T, times, np.where(np.arange(25) % 2 == 0, 4.0, 22.0))
    rate = np.gradient(u, 0.02)
    phase = np.cumsum(np.where(np.abs(rate) < 8.0, 0.06, 0.2) * rng.uniform(0.6, 1.4, len(T)))
    loss = np.where(np.abs(rate) < 8.0, 0.08 * (phase % 1.0), 0.0)
    y = np.empty_like(u)
    last = 3.0
    for k, v in enumerate(u):
        low, high = np.exp(-0.5) * v * (1.0 - loss[k]), np.exp(0.5) * v * (1.0 + loss[k])
        last = y[k] = max(low, min(last, high))
    noisy = [c + 0.02 * rng.standard_normal(len(T)) for c in (u, y)]
    return Run(f"r{seed}", "act", T, *noisy, config_id="a", trajectory=f"m{seed}")


@pytest.mark.parametrize("effects", asked((LIKE, None), LIKE))
def test_jumps_at_moments_that_no_fit_meets_are_of_the_family(effects):
    found = gather([jumping(1), jumping(2)], Question(max_effects=1, effects=effects)).search.singles
    mean, exact = found["stick_slip"]
    assert mean.fit.free[0].parameter.name == "mean_ratio" and mean.evidence > exact.evidence + 1000.0
    rivals = [w[0].evidence for i, w in found.items() if i not in ("stick_slip", "stribeck", "dwell_aging")]
    assert mean.evidence > max(rivals) + 1000.0

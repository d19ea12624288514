"""Presliding by Dahl's law: what it leaves of other simulators' laws, and where the two laws of the effect meet."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from sstl_cli.physics.effect import Mechanics, Transition
from sstl_cli.physics.effects import get
from sstl_cli.physics.transmission import activate, predict
from sstl_cli.physics.transmission.model import drive_of
from sstl_cli.physics.variant import QUIET, VariantRun, VariantSpec, simulate_variant

TIME = np.arange(1500) / 100.0
COMMAND = np.interp(TIME, [0.0, 2, 3, 5, 5.5, 7, 8.5, 10, 12, 15], [1.0, 22, 22, 2, 2, 18, 6, 15, 3, 20])
THETA = 0.5


def model(values, theta=THETA, start_n=0.6):
    drive = drive_of("act", "CP", 0.01, COMMAND, Mechanics())
    return predict(drive, theta, activate({"presliding": values} if values else {}), start_n)


@pytest.mark.parametrize(("law", "most"), [("dahl", 0.15), ("bouc_wen", 0.25)])
def test_laws_that_approach_their_limit_are_followed(law, most):
    spec = VariantSpec(laws={"presliding": law}, law_seed=1)
    run = VariantRun("act", THETA, "CP", TIME, "tension", COMMAND)
    truth = simulate_variant(spec, run, {"presliding": {"breakaway_mm": 0.3}}, QUIET, 3).tension_out_n

    def left(x):
        return model({"dahl_mm": x[1], "tail": x[2]}, x[0], float(truth[0])) - truth

    fitted = least_squares(left, [THETA, 0.2, 0.5], bounds=([0.3, 0.0, 0.0], [0.8, 1.5, 1.0]), x_scale=[0.1, 0.1, 0.3], diff_step=1e-3)
    cut = least_squares(
        lambda x: model({"breakaway_mm": x[1], "spread": x[2]}, x[0], float(truth[0])) - truth,
        [THETA, 0.2, 0.5],
        bounds=([0.3, 0.0, 0.0], [0.8, 1.5, 1.0]),
        x_scale=[0.1, 0.1, 0.3],
        diff_step=1e-3,
    )
    base = least_squares(lambda x: model({}, x[0], float(truth[0])) - truth, [THETA])
    share, shares = np.sqrt(fitted.cost / base.cost), np.sqrt(cut.cost / base.cost)
    assert share < most < shares
    assert fitted.x[0] == pytest.approx(THETA, abs=0.01)


def test_short_break_away_is_the_play():
    still = model({})
    assert np.abs(model({"dahl_mm": 1e-6}) - still).max() < 2e-3
    assert np.abs(model({"dahl_mm": 0.0}) - still).max() == 0.0


@pytest.mark.parametrize("tail", [0.0, 0.5, 1.0])
def test_a_reversal_leaves_no_jump(tail):
    seen = model({"dahl_mm": 0.2, "tail": tail})
    inside = np.abs(np.diff(COMMAND)).max() * np.exp(THETA) + 1e-3
    assert np.abs(np.diff(seen)).max() < inside


def test_a_little_of_the_other_law_changes_the_distance_only():
    def laid(values):
        t = Transition()
        effect = get("presliding")
        effect.transition(t, effect.complete(values), None)
        return t.breakaway_mm, t.tail

    assert laid({"breakaway_mm": 0.3, "dahl_mm": 0.01}) == (pytest.approx(0.31), Transition().tail)
    assert laid({"breakaway_mm": 0.01, "dahl_mm": 0.3}) == (pytest.approx(0.31), 0.5)

"""Shares of stages against Shapley's formula over runs that are simulated here, one stage right after the other."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.plant import Plant, PlayTendon, TensionLoop, track
from sstl_cli.control.references import sinusoid
from sstl_cli.diagnosis import stages
from sstl_cli.diagnosis.stages import STAGES, Stream, stage_shares

TRUE, BELIEVED, TAU, DT = Theta(0.583, -1.444, 1.688, -1.043), Theta(0.55, -1.0, 1.75, -0.8), 0.2, 0.05


@pytest.fixture
def recorded(monkeypatch):
    """A stream of a believed controller on a true plant with a loop that lags and something that no line describes; what is made of it is known."""
    reference = sinusoid(DT)
    done = track(Controller(BELIEVED, Options(dt_s=DT)), Plant(PlayTendon(TRUE), TensionLoop(TAU)), reference.tension_n)
    more = 0.2 * np.sin(reference.time_s)
    names = np.array(["PB", "PP", "RB", "RP", "SAFE"])
    monkeypatch.setattr(stages, "_believed", lambda stream: BELIEVED)
    monkeypatch.setattr(stages, "_true", lambda stream: TRUE)
    monkeypatch.setattr(stages, "_loop_lag", lambda stream, dt: TAU)
    return Stream("s", reference.time_s, reference.tension_n, done.command, done.tension_in, done.tension_out + more, names[done.phase])


def error2(s, right):
    """Return the mean squared error where some stages are right, as their names say."""
    mapping, bias = (TRUE if x in right else BELIEVED for x in ("mapping", "bias"))
    lines = Theta(mapping.gamma_p, bias.beta_p, mapping.gamma_r, bias.beta_r)
    how = Options(dt_s=DT, reversal="play") if "backlash handling" in right else Options(dt_s=DT, reversal="paper")
    loop = TensionLoop(0.0) if "loop lag" in right else TensionLoop(TAU)
    out = track(Controller(lines, how), Plant(PlayTendon(TRUE), loop), s.reference_n).tension_out
    beside = np.zeros(len(out)) if "plant" in right else s.output_n - PlayTendon(TRUE)(s.input_n, DT)
    return float(np.mean((s.reference_n - out - beside) ** 2))


def test_a_share_is_what_a_stage_takes_off_on_average_over_all_orders(recorded):
    known = {}

    def of(names):
        key = frozenset(names)
        return known[key] if key in known else known.setdefault(key, error2(recorded, key))

    orders = list(permutations(STAGES))
    made = {stage: np.mean([of(o[: o.index(stage)]) - of(o[: o.index(stage) + 1]) for o in orders]) for stage in STAGES}
    whole = sum(made.values())
    found = stage_shares(recorded)
    assert found.share_pct == pytest.approx({k: 100.0 * v / whole for k, v in made.items()})
    assert found.simulated_rmse_n == pytest.approx(np.sqrt(of(()))) and (found.believed, found.true, found.loop_tau_s) == (
        BELIEVED,
        TRUE,
        TAU,
    )
    assert found.rmse_n == pytest.approx(np.sqrt(np.mean((recorded.reference_n - recorded.output_n) ** 2)))


def test_a_controller_that_believes_the_truth_of_a_plant_without_a_rest_has_no_error_to_share(recorded, monkeypatch):
    monkeypatch.setattr(stages, "track", lambda controller, plant, reference: type("T", (), {"tension_out": reference})())
    still = Stream(
        *(getattr(recorded, k) for k in ("run_id", "time_s", "reference_n", "command_n", "input_n")),
        PlayTendon(TRUE)(recorded.input_n, DT),
        recorded.phase,
    )
    found = stage_shares(still)
    assert set(found.share_pct.values()) == {0.0} and found.simulated_rmse_n == 0.0

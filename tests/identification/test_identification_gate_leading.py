"""A run that leads beside others in time: by what a delay leaves, and by what friction leaves without one."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from sstl_cli.identification.gate.ahead import Ahead
from sstl_cli.identification.gate.leading import leading

SENSOR = SimpleNamespace(refresh_s=0.0)


def run(delay_s: float, ahead: Ahead | None = None, by_speed_n: float = 0.5) -> SimpleNamespace:
    """Return what the rule looks at of a run at 200 Hz whose lines are best moved by so much, which leaves 0.05 N."""
    causes = SimpleNamespace(speed=SimpleNamespace(rms_n=by_speed_n), moved=SimpleNamespace(rms_n=0.05), noise_n=0.02)
    play = SimpleNamespace(delay_s=delay_s, explained=0.999, delay_se=0.001, gamma_p=0.5, gamma_r=1.9)
    return SimpleNamespace(
        play=play, ahead=ahead, causes=causes, tendon_like=True, wide=True, dt_s=0.005, loop_s=4.0, sensors=(SENSOR, SENSOR)
    )


@pytest.mark.parametrize(
    ("left", "without", "leads"),
    [
        # noises that lines with a delay leave, and friction of any law without one
        (1.05, 3.5, True),
        (2.0, 3.5, True),
        # a tube that rubs at one place turns the output early: bundled friction leaves less than any delay
        (3.9, 3.5, False),
        # where friction alone leaves hardly more than noise there is nothing to tell
        (1.05, 1.05, False),
    ],
)
def test_one_run_leads_where_a_delay_leaves_less_than_friction_without_one(left, without, leads):
    early = run(-0.04, Ahead(-0.04, left, without))
    assert leading([run(0.001), run(0.002), early, run(0.003)]) == ([early] if leads else [])


@pytest.mark.parametrize(("by_speed_n", "leads"), [(0.04, False), (0.14, False), (0.16, True), (float("nan"), True)])
def test_a_lead_that_friction_falling_with_speed_explains_nearly_as_well_is_no_clock_s(by_speed_n, leads):
    early = run(-0.04, Ahead(-0.04, 2.0, 3.5), by_speed_n)
    assert leading([run(0.001), run(0.002), early, run(0.003)]) == ([early] if leads else [])


@pytest.mark.parametrize(
    ("lead_s", "left", "others", "leads"),
    [
        (-0.08, 2.0, (0.0, -0.001, 0.002), True),
        # friction that falls with speed turns most outputs early, those of some movements by more: a clock's lead leaves nothing
        (-0.08, 2.0, (-0.02, -0.012, -0.025), False),
        (-0.08, 1.05, (-0.02, -0.012, -0.025), True),
        # a movement that repeats looks the same after a loop
        (-4.0, 2.0, (0.0, -0.001, 0.002), False),
        (-4.0, 1.05, (0.0, -0.001, 0.002), True),
    ],
)
def test_where_others_lead_and_beyond_half_a_loop_only_a_delay_that_leaves_noise_alone_is_a_clocks(lead_s, left, others, leads):
    early = run(lead_s, Ahead(lead_s, left, 5.0))
    assert leading([*(run(d) for d in others), early]) == ([early] if leads else [])

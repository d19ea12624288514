"""Which rows of Theta are used: one rule for learning a mapping and for driving with lines."""

from __future__ import annotations

import math

import pyarrow as pa
import pytest
from mapping_data import theta

from sstl_cli.mapping.configurations import configurations
from sstl_cli.mapping.pairs import pairs_of
from sstl_cli.steps.compensate import cases_of


def row(run_id: str, system: str = "act", config: str | None = "C", slopes: tuple = (0.5, 1.6), **more: object) -> dict:
    lines = {"gamma_p": slopes[0], "beta_p": -1.0, "gamma_r": slopes[1], "beta_r": -1.2}
    return {
        "run_id": run_id,
        "config_id": config,
        "system": system,
        "location": "CP",
        "lead_mm": None,
        "loops": 1,
        **lines,
        "status": "ok",
        **more,
    }


LOOP = row("loop", "sstl", slopes=(0.25, 3.2))
BAD = {
    "status": row("bad", status="the sensor slipped", slopes=(0.7, 1.0)),
    "null": row("bad", slopes=(0.5, None)),
    "number": row("bad", slopes=(0.5, math.nan)),
    "slope": row("bad", slopes=(-0.5, 1.6)),
    "system": row("bad", system="sst"),
}


@pytest.mark.parametrize("why", list(BAD))
def test_training_and_driving_use_the_same_rows(why: str) -> None:
    """A run that is not usable takes nothing from a good one beside it, whoever asks."""
    made = theta([row("good"), BAD[why], LOOP])
    pairs = pairs_of(made)
    cases, aside = cases_of(made)
    assert pairs.act.tolist() == [[0.5, 1.6]] and (cases[0].act.gamma_p, cases[0].act.gamma_r) == (0.5, 1.6)
    assert len(cases) == 1 and cases[0].sstl == (0.25, 3.2)
    assert list(pairs.aside) == ["bad"] and list(aside) == ["C (bad)"]
    assert pairs.aside["bad"] == aside["C (bad)"]


def test_a_row_that_says_it_is_not_ok_says_so() -> None:
    _, (unused,) = configurations(theta([BAD["status"], LOOP]), alone=False)
    assert (unused.run_id, unused.config, unused.why) == ("bad", "C", "the sensor slipped")


def test_a_run_without_a_configuration_is_one_of_its_own_or_none() -> None:
    made = theta([row("a", config=None), LOOP])
    (own, loop), unused = configurations(made, alone=True)
    assert not unused and (own.name, own.loop, own.tendons[""].runs) == ("a", None, ("a",)) and not loop.tendons
    _, (unused_row,) = configurations(made, alone=False)
    assert "no config_id" in unused_row.why


def test_tendons_are_apart_and_runs_of_one_averaged() -> None:
    rows = [row("a", tendon="left"), row("b", tendon="left", slopes=(0.7, 1.8)), row("c", tendon="right", location=None), LOOP]
    made = pa.Table.from_pylist([{"tendon": None, **r} for r in rows])
    ((one,), unused) = configurations(made, alone=False)
    assert not unused and list(one.tendons) == ["left", "right"]
    assert one.tendons["left"].slopes == pytest.approx((0.6, 1.7)) and one.tendons["left"].runs == ("a", "b")
    assert one.tendons["right"].location is None and one.loop is not None and one.loop.slopes == (0.25, 3.2)

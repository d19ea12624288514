"""What a log is called, how it is ordered, cut into files, dated or measured in changes nothing that is said of it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import chain

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rig_logs import record

from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import read_runs, write_runs
from sstl_cli.diagnosis.latent import latent
from sstl_cli.physics.scenario import Trajectory
from sstl_cli.steps import diagnose

MOVES = (Trajectory(kind="random", duration_s=16.0, low_n=2.0), Trajectory(kind="ramp_hold", duration_s=12.0))
OPTIONS = diagnose.DiagnoseOptions(effects=("zero_offset", "gain_error", "const_friction"), max_effects=1, physics=False)
OFFSET_N = 0.07
# sums in another order, and instants that are rounded, move a number of thousands of nats by this
ROUNDING = 1e-7
# the search stops within a tenth of a nat of an optimum that it comes to from elsewhere in other units; the noise is as likely
# there to 0.03 nats, where slow noise (known to a third) is 3 % larger: evidence goes by one over its square
STOPPING, EVIDENCE = 4e-3, 0.06
FEW = settings(max_examples=3, deadline=None)


@cache
def runs():
    return tuple(record({"zero_offset": {"z_out_act_n": OFFSET_N}}, moves=MOVES))


def said(log):
    """Verdict, and numbers: evidence of every effect, base, and the offset of the sensor."""
    found = diagnose.run(list(log), OPTIONS)
    verdict, search = found.document()["verdict"], found.evidence.search
    offset = search.best(("zero_offset",)).fit
    numbers = {k: v[0].evidence for k, v in search.singles.items()}
    at = dict(zip((f.parameter.name for f in offset.free), offset.values, strict=True))
    return (verdict["status"], verdict["effects"]), numbers, at["z_out_act_n"] * found.evidence.problem.unit_n


@cache
def plain():
    return said(runs())


@pytest.mark.slow
@pytest.mark.slow
@given(
    order=st.permutations(range(8)),
    names=st.permutations(range(8)),
    configs=st.permutations(["a", "k", "z"]),
    movements=st.permutations(["m", "n", "x"]),
    shift_s=st.floats(-1e4, 1e6),
)
@FEW
def test_order_names_and_dates_say_nothing(order, names, configs, movements, shift_s):
    log = [
        replace(
            r,
            run_id=f"{names[i]} of a day",
            config_id=configs[sorted({x.config_id for x in runs()}).index(r.config_id)],
            trajectory=movements[sorted({x.trajectory for x in runs()}).index(r.trajectory)],
            time_s=r.time_s + shift_s,
        )
        for i, r in enumerate(runs())
    ]
    verdict, numbers, offset_n = said([log[i] for i in order])
    assert verdict == plain()[0]
    assert numbers == pytest.approx(plain()[1], rel=ROUNDING, abs=1e-3)
    assert offset_n == pytest.approx(plain()[2], rel=1e-6)


@given(unit=st.floats(-3.0, 3.0).map(lambda x: 10.0**x))
@FEW
@pytest.mark.slow
def test_another_unit_of_force_says_the_same(unit):
    log = [replace(r, tension_in_n=unit * r.tension_in_n, tension_out_n=unit * r.tension_out_n) for r in runs()]
    verdict, numbers, offset_n = said(log)
    assert verdict == plain()[0]
    assert offset_n / unit == pytest.approx(plain()[2], rel=STOPPING)
    big = {k: v for k, v in numbers.items() if v > 1000.0}
    assert big == pytest.approx({k: plain()[1][k] for k in big}, rel=EVIDENCE)


def test_one_file_or_several_hold_the_same_runs(tmp_path):
    source = Provenance("test")
    write_runs(tmp_path / "all.parquet", runs(), source)
    parts = [tmp_path / f"part{k}.parquet" for k in range(3)]
    for k, path in enumerate(parts):
        write_runs(path, runs()[k::3], source)
    whole = {r.run_id: r for r in read_runs(tmp_path / "all.parquet")}
    split = {r.run_id: r for r in chain.from_iterable(map(read_runs, parts))}
    assert whole.keys() == split.keys()
    for name, r in whole.items():
        assert all(np.array_equal(getattr(r, c), getattr(split[name], c)) for c in ("time_s", "tension_in_n", "tension_out_n"))


@given(unit=st.floats(-6.0, 6.0).map(lambda x: 10.0**x), shift=st.floats(-100.0, 100.0), turned=st.booleans())
@settings(max_examples=10, deadline=None)
def test_the_latent_input_knows_no_unit_no_origin_and_no_sign(unit, shift, turned):
    t = np.arange(0.0, 10.0, 0.02)
    y = 10.0 * np.abs((t / 4.0) % 1.0 - 0.5) + 0.02 * np.random.default_rng(3).standard_normal(len(t))
    here, factor = latent(y, 0.02, 0.02), -unit if turned else unit
    there = latent(factor * y + unit * shift, 0.02, 0.02 * unit)
    assert there.value == pytest.approx(factor * here.value + unit * shift, rel=1e-6, abs=1e-6 * unit)
    assert np.sqrt(there.variance) == pytest.approx(unit * np.sqrt(here.variance), rel=1e-5)

"""The steps of the reproduction on small inputs."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.mapping.split import Splits
from sstl_cli.paper import chosen, probe, scores, table_i_ii, table_iii, table_iv
from sstl_cli.paper.probe import FULL, PARTIAL, Probe
from sstl_cli.paper.published import entries
from sstl_cli.paper.settings import FITTED, PARTS, STATED, fitted_values, partly
from sstl_cli.paper.spread import of_draws


@pytest.fixture(scope="module")
def slopes():
    return table_i_ii.run(0)


@pytest.fixture(scope="module")
def prepared(slopes):
    truth = table_iv.tracked(0)
    exact = np.array([[truth[p].act.gamma_p, truth[p].act.gamma_r] for p in ("NP", "CP", "ND")])
    # cases come in the order NP, CP, ND: a perfect mapping
    return table_iv.prepare(0, lambda sstl: exact, table_iv.biases(slopes))


def test_chosen():
    assert chosen.chosen("all") == chosen.DEFAULT
    assert chosen.chosen("II, I") == ("I", "II")
    with pytest.raises(UsageError, match="E803"):
        chosen.chosen("V")
    with pytest.raises(UsageError, match="E803"):
        chosen.chosen(",")


def test_tables_come_from_the_recordings_not_from_the_generator(slopes):
    rows = slopes.theta.to_pylist()
    assert len(rows) == 80 and {r["status"] for r in rows} == {"ok"}
    act = np.array([[r["gamma_p"], r["gamma_r"]] for r in rows if r["system"] == "act"])
    assert slopes.entries["II", "act_gamma_p", "mean"] == pytest.approx(act[:, 0].mean())
    assert slopes.entries["II", "act_product", "max"] == pytest.approx(act.prod(axis=1).max())
    assert slopes.entries["I", "release", "R"] > 0.9


def test_of_draws():
    k = ("I", "a", "b")
    made = of_draws([{"x": {k: 1.0}}, {"x": {k: 3.0}}])
    assert made.seeds == 2 and made.of("x")[k] == pytest.approx((2.0, math.sqrt(2.0)))
    assert of_draws([{"x": {k: 1.0}}]).of("x")[k] == (1.0, 0.0)


def test_stated_block_meets_the_checked_facts(prepared):
    """PAPER.md: Table II's means and an ideal loop give 4.45/3.54 without compensation, at CP within the lines' scatter."""
    made = table_iv.block(STATED, prepared, 0, ("none", "DI"))
    assert made.entries["IV", "sinusoid none", "rmse_CP"] == pytest.approx(4.45, abs=0.25)
    assert made.entries["IV", "sinusoid none", "std_CP"] == pytest.approx(3.54, abs=0.1)
    assert made.entries["IV", "sinusoid DI", "rmse_CP"] < 0.05


def test_fitted_block_meets_the_uncompensated_row(prepared):
    made = table_iv.block(FITTED, prepared, 0, ("none",))
    for place, rmse, std in (("NP", 5.69, 3.66), ("CP", 5.75, 3.65), ("ND", 5.79, 3.78)):
        assert made.entries["IV", "sinusoid none", f"rmse_{place}"] == pytest.approx(rmse, abs=0.15)
        assert made.entries["IV", "sinusoid none", f"std_{place}"] == pytest.approx(std, abs=0.15)


def test_partly_switches_every_part():
    assert replace(partly(tuple(PARTS)), name="", title="") == replace(FITTED, name="", title="")
    assert replace(partly(()), name="", title="") == replace(STATED, name="", title="")
    assert partly(("loop lag",)).lag_s == 0.3 and partly(("loop lag",)).lines is None


def test_distance():
    published = {(e.table, e.row, e.column): e.value for e in entries()}
    assert scores.distance(published, published) == 0.0
    off = {k: v + 0.5 for k, v in published.items()}
    assert scores.distance(off, published) == pytest.approx(0.5)


def test_fourteen_numbers_were_fitted():
    assert len(dict(fitted_values())) == 14
    assert dict(fitted_values())["loop lag s"] == FITTED.lag_s


def test_a_split_that_leaks_is_caught():
    names = ("a", "b", "c", "d")
    table_iii.require_apart(names, Splits(names, (0,), ("fvhf",)))
    with pytest.raises(SstlError, match="E808"):
        table_iii.require_apart(names, Splits(names, (0,), ("fvff",)))
    with pytest.raises(SstlError, match="E808"):
        table_iii.require_apart(("a", "a", "b"), _Leaking(("a", "b"), (0,), ("hf",)))


class _Leaking(Splits):
    """Splits whose parts overlap: the held-out part is trained on too."""

    def mask(self, config_id, parts):
        return np.ones((1, len(config_id)), dtype=bool)


def test_shortest_probe():
    curve = [
        Probe(FULL, 12.0, 80.0, 0.010, 0.02, 0.3),
        Probe(FULL, 6.0, 80.0, 0.0109, None, 0.4),
        Probe(PARTIAL, 3.0, 20.0, 0.02, None, 0.32),
    ]
    assert probe.shortest(curve, "lines_error").time_s == 6.0
    assert probe.shortest(curve, "segmented_error").time_s == 12.0
    assert probe.shortest(curve, "tracking_n").time_s == 3.0

"""The published numbers against arithmetic done here, not against the code that finds contradictions."""

import numpy as np
import pytest

from sstl_cli.paper import published
from sstl_cli.paper.contradictions import rms_inverse

LOCATIONS = ("NP", "CP", "ND")


def test_every_table_is_there_and_no_entry_twice():
    entries = published.entries()
    keys = [(e.table, e.row, e.column) for e in entries]
    assert len(set(keys)) == len(keys)
    sizes = {t: len(published.of_table(t)) for t in published.TABLES}
    assert sizes == {"I": 10, "II": 24, "bias": 8, "III": 15, "range": 4, "IV": 90, "summary": 14, "headline": 2}


def test_spread_is_that_of_table_iii():
    entry = next(e for e in published.of_table("III") if (e.row, e.column) == ("skip-inv", "rmse_r"))
    assert (entry.value, entry.spread, entry.text()) == (0.0214, 0.014, "0.0214")
    assert all(e.spread is None for e in published.of_table("III") if e.column == "total")


def test_rms_inverse_by_numerical_integration():
    phase = (np.arange(100_000) + 0.5) / 100_000 * 2 * np.pi
    assert rms_inverse() == pytest.approx(np.sqrt(np.mean((10 + 5 * np.sin(phase)) ** -2.0)), rel=1e-9)


def test_the_impossible_mape_entries_are_those_of_the_checked_facts():
    found = {(e.row, e.column) for e in published.of_table("IV") if e.contradicted and e.column.startswith("mape")}
    expected = {("sinusoid no-bias", f"mape_{p}") for p in LOCATIONS}
    assert found == expected | {("sinusoid DI", "mape_ND"), ("sinusoid proposed", "mape_ND")}


def test_fits_that_miss_the_means_are_flagged():
    found = {(e.row, e.column) for e in published.of_table("I") if e.contradicted}
    assert ("release", "slope") in found and ("release", "bias") in found
    assert not any(c in ("R", "rmse_id", "rmse_fit") for _, c in found)


@pytest.mark.parametrize("trajectory", ["sinusoid", "random"])
def test_summary_agrees_with_table_iv(trajectory):
    for method in ("none", "no-bias", "DI", "proposed"):
        row = f"{trajectory} {method}"
        mean = np.mean([published.value("IV", row, f"rmse_{p}") for p in LOCATIONS])
        assert published.value("summary", row, "rmse") == pytest.approx(mean, abs=0.0101)


def test_unknown_number_is_an_error():
    with pytest.raises(KeyError):
        published.value("IV", "sinusoid none", "red_NP")

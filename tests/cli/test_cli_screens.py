"""What commands say at 80 columns: whole names, no unit "1", small numbers in words, nothing wider than the terminal."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sstl_cli.cli import _diagnose_show, _other_files, _watch_show
from sstl_cli.cli.info import _span
from sstl_cli.cli.render import Screen, begin
from sstl_cli.core.documents.control import StagesDocument, StageShares
from sstl_cli.core.documents.diagnosis import DiagnosisDocument

NOTHING = {
    "schema": "sstl.diagnosis/1",
    "sentence": "As far as this data can show nothing has changed since the simulator was accepted: it leaves 0.0031 N beyond the noise, where it was 0.0035 N.",
    "verdict": {
        "status": "none",
        "effects": [],
        "confidence": None,
        "ambiguity_group": [],
        "why": "",
        "would_have_shown": [
            {"effect": "zero_offset", "parameter": "z_out_act_n", "size": 0.0043, "unit": "N", "gap_n": 0.0025},
            {"effect": "pulley_friction", "parameter": "m_p", "size": 0.00068, "unit": "1", "gap_n": 0.0013},
        ],
    },
    "gap": {"rmse_base_n": 0.022, "rmse_retuned_n": 0.022, "rmse_with_effect_n": None, "noise_floor_n": 0.021}
    | {"shrink_pct": 0.0, "shrink_ci95_pct": None, "explained_of_reducible_pct": None, "held_out": True},
    "where": [{"system": "act", "phase": "PP", "config_id": "A", "share_pct": 100.0, "rmse_n": 0.02}],
    "candidates": [],
    "next_experiment": None,
    "downstream": {"config_id": "A", "tracking": [{"reference": "sinusoid", "rmse_without_n": 0.24, "rmse_with_n": 3.1e-15}]},
    "notes": ["the clock of three runs is uneven; they were put on an even one before they were compared with anything"],
}


@pytest.fixture
def at_80(monkeypatch):
    # a call before this in the same process may have been a quiet one
    begin()
    monkeypatch.setenv("COLUMNS", "80")


def test_a_diagnosis_fits_and_spells_units_and_small_numbers(capsys, at_80):
    _diagnose_show.answer(Screen(), DiagnosisDocument(**NOTHING))
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 80
    words = " ".join(shown.split())
    assert words.startswith(NOTHING["sentence"])
    assert "would have shown: pulley_friction (m_p) from 0.00068 on, a gap of 0.0013 N" in words
    assert "would have shown: zero_offset (z_out_act_n) from 0.0043 N on" in words and words.index("pulley_friction") < words.index(
        "zero_offset"
    )
    assert "to < 0.001 N instead of 0.24 N" in words and "e-15" not in words
    assert words.endswith("before they were compared with anything") and words.count("note:") == 1


def test_negative_shares_of_a_stage_are_explained(capsys, at_80):
    stream = StageShares.model_construct(
        run_id="CP-020-sinusoid-proposed", rmse_n=0.009, share_pct={"mapping": -2.0, "bias": -15.6, "loop lag": 117.6}
    )
    _diagnose_show.stages(Screen(), StagesDocument.model_construct(streams=[stream]))
    assert "A share below 0 cancels a part of the others." in capsys.readouterr().out
    # what rounds to nothing is nothing
    stream = stream.model_copy(update={"share_pct": {"mapping": -0.01, "bias": 0.01, "loop lag": 100.0}})
    _diagnose_show.stages(Screen(), StagesDocument.model_construct(streams=[stream]))
    assert "below 0" not in capsys.readouterr().out


def a_loop(**other):
    theta = {"gamma_p": 0.61282, "beta_p": -0.0031, "gamma_r": None, "beta_r": None}
    found = {
        "run": SimpleNamespace(system="sstl", tendon=None, config_id="CP-020", time_s=np.array([7.43, 12.34])),
        "segmentation": SimpleNamespace(theta=theta, status="release: no propagation reached"),
        "number": 9, "gap_n": 0.02221, "learning": False, "level": 1.12, "mapped": (0.6125, 1.6328), "range": "edge",
    }  # fmt: skip
    return SimpleNamespace(**{**found, **other})


def test_a_watched_loop_stands_below_its_heading():
    heading, line = _watch_show.heading("N"), _watch_show.loop(a_loop(), 80)[0]
    assert len(heading) <= 80 and heading.split() == [
        "loop",
        "stream",
        "time",
        "s",
        "Γ_p",
        "β_p",
        "N",
        "Γ_r",
        "β_r",
        "N",
        "gap",
        "N",
        "chart",
    ]
    # each number ends where its heading ends
    for name, value in (("Γ_p", "0.6128"), ("β_p N", "-0.003"), ("gap N", "0.0222")):
        assert heading.index(name) + len(name) == line.index(value) + len(value)
    assert line.split() == ["9", "sstl", "CP-020", "7.4-12.3", "0.6128", "-0.003", "-", "-", "0.0222", "112", "%"]


def test_what_has_no_room_beside_a_loop_stands_below_it():
    below = "-> act 0.6125 1.6328; edge range; release: no propagation reached"
    narrow = _watch_show.loop(a_loop(), 80)
    assert len(narrow) == 2 and narrow[1].strip() == below and max(map(len, narrow)) <= 80
    (wide,) = _watch_show.loop(a_loop(), 200)
    assert wide == f"{narrow[0]}  {below}"
    quiet = a_loop(mapped=None, range=None, segmentation=SimpleNamespace(theta=a_loop().segmentation.theta, status="ok"))
    assert len(_watch_show.loop(quiet, 80)) == 1


def test_notes_break_between_words_too(capsys, at_80):
    Screen().note("1 of 10 inputs (10 %) lie outside the trained range: predictions there are extrapolated")
    assert max(map(len, capsys.readouterr().err.splitlines())) <= 80


def test_what_continues_a_line_stands_further_in(capsys, at_80):
    Screen().say("  held-out error falls by 92.9 % [90.5, 93.9]; 100.0 % of the error above the noise floor")
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith("  held-out") and second == "    noise floor"


@pytest.mark.parametrize(
    ("low", "high", "shown"),
    [
        (-0.0612, 30.049, "-0.1..30.0"),
        (0.0, 0.25, "0.000..0.250"),
        (-0.01, 2000.4, "0..2000"),
        (3.0, 3.0, "3.00..3.00"),
        (0.0, float("inf"), "0.00..inf"),
    ],
)
def test_ranges_are_as_long_as_they_need_to_be(low, high, shown):
    assert _span(low, high) == shown


def test_fields_of_a_document_are_brief():
    assert _other_files._brief({"rmse_n": 0.91228101, "why": None, "in": "a" * 64}) == "rmse_n 0.9123, why -, in aaaaaaaaaaaa"
    cut = _other_files._brief("several words " * 20)
    assert len(cut) <= 104 and cut.endswith("words ...")
    assert _other_files._brief(None) == "-"

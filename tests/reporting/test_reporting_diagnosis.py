"""The diagnosis on the page: every tendon by its name, plain words first, and all that a document may add."""

from __future__ import annotations

import json
import re
from functools import cache
from html import unescape
from pathlib import Path

import numpy as np
import pytest
import reporting_inputs as made

from sstl_cli.diagnosis import constants
from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.documents import read
from sstl_cli.reporting.figures import candidates, waterfall
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.load import load
from sstl_cli.reporting.scored import Scored
from sstl_cli.reporting.table import cell, loose, probability
from sstl_cli.reporting.words import MOST_SURE, how_far, how_sure, listed, published, shrinkage, where
from sstl_cli.steps import report


def shown(document, *more) -> str:
    return _shown(json.dumps([{**document, "file": "d"}, *more]))


@cache
def _shown(documents: str) -> str:
    """The page of documents, drawn once for all tests that ask for the same."""
    files = [("diagnosis", "d", "0")]
    return report.run(Inputs(diagnosis=[read(Diagnosed, d) for d in json.loads(documents)], files=files)).html


def words_of(html: str) -> str:
    # a name may break behind an underscore
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", html.replace("<wbr>", ""))).split())


def two_tendons():
    """Return a document as ``sstl diagnose`` writes it for two tendons, the second leading."""
    keys = ("verdict", "gap", "where", "candidates", "next_experiment")
    one, two = made.diagnosis(("zero_offset",)), made.diagnosis(("gain_error",))
    one["gap"]["rmse_retuned_n"], two["gap"]["rmse_retuned_n"] = 0.11, 0.77
    blocks = [
        {"tendon": "left", "sentence": "It is an offset.", **{k: one[k] for k in keys}},
        {"tendon": "right", "sentence": "It is a gain.", **{k: two[k] for k in keys}},
    ]
    return {**two, "tendon": "right", "sentence": "Tendon right: It is a gain.", "tendons": blocks}


def test_every_tendon_is_drawn_and_named(tmp_path):
    path = tmp_path / "d.json"
    path.write_text(json.dumps(two_tendons()))
    html = report.run(load([path])).html
    section = html.split('<section id="diagnosis"')[1].split("</section>")[0]
    names = [unescape(n) for n in re.findall(r'<h3 class="name">(.*?)</h3>', section)]
    assert names == ["Tendon right", "Tendon left"]
    right, left = section.split('<h3 class="name">')[1:]
    assert "It is a gain." in right and "It is an offset." in left
    # each its own pictures and numbers; the loops are the leading tendon's alone
    assert "0.77 N" in right and "0.77 N" not in left and "0.11 N" in left
    assert "Measured and simulated loops</h3>" in right and "Measured and simulated loops" not in left


def test_a_tendon_that_could_not_be_judged_is_named_with_its_reason():
    document = two_tendons()
    verdict = {"status": "unknown", "effects": [], "confidence": None, "ambiguity_group": [], "why": "no loop at all"}
    document["tendons"][0] = {"tendon": "left", "sentence": "not diagnosed: no loop at all", "verdict": verdict}
    html = shown(document)
    assert "Tendon left" in html and "not diagnosed: no loop at all" in html


def test_several_files_have_a_heading_each_and_unique_ids():
    html = shown(made.diagnosis(), {**made.diagnosis(("viscous",)), "file": "other.json"})
    assert re.findall(r'<h3 class="name">(.*?)</h3>', html) == ["d", "other.json"]
    ids = re.findall(r'\bid="([^"]+)"', html)
    assert len(ids) == len(set(ids))


def test_the_first_screen_says_where_which_how_far_and_how_sure():
    html = shown(made.diagnosis())
    document = read(Diagnosed, made.diagnosis())
    first = html.split("<svg")[0]
    for name in ("Where", "Which", "How far", "How sure"):
        assert f"<dt>{name}</dt>" in first
    # the sstl rows weigh 56 of 62
    assert where(document).startswith("90 % in the sensing loop, 10 % in the actuation tendon. Most of it while releasing")
    assert how_far(document) == "Error 0.61 N as given → 0.44 N re-tuned → 0.041 N with the effect; noise alone is 0.028 N."
    assert (
        shrinkage(document)
        == "90.7 % less (95 %: 89.9 to 91.4), on recordings kept out of the fit; 96.8 % of the error above the noise floor."
    )
    known = read(Diagnosed, {**made.diagnosis(), "gap": {**made.diagnosis()["gap"], "known_misfit_n": 0.3}})
    assert shrinkage(known).endswith("; 96.8 % of the error above the noise floor and the known misfit.")
    worse = {**made.diagnosis()["gap"], "shrink_pct": -20.6, "shrink_ci95_pct": [-103.2, 45.5]}
    rises = read(Diagnosed, {**made.diagnosis(), "gap": worse})
    assert shrinkage(rises) == "20.6 % more (95 %: -45.5 to 103.2), on recordings kept out of the fit."
    assert how_sure(document, []) == "94 %: of 100 such verdicts about 94 are right."
    assert "Friction in the sensing loop&#39;s pulley" in first or "Friction in the sensing loop's pulley" in first


def test_the_sealed_check_beside_it_is_quoted():
    blind = read(Scored, {"reliability": [{"p_low": 0.9, "p_high": 1.0, "share_right": 0.75, "n": 8}]})
    assert how_sure(read(Diagnosed, made.diagnosis()), [blind]).endswith("In the sealed check 6 of 8 verdicts with this confidence were.")


def test_without_a_score_the_published_check_is_quoted():
    document = made.diagnosis()
    document["verdict"]["confidence"] = 0.997
    first = words_of(shown(document).split("<svg")[0])
    # as the sentence of a diagnosis has it
    assert f"{MOST_SURE:.0f} %: of 100 such verdicts about {MOST_SURE:.0f} are right." in first and MOST_SURE == constants.MOST_SURE
    row = published().reliability[-1]
    assert row.p_low <= 0.997 <= row.p_high
    assert f"In the published sealed check {round(row.share_right * row.n)} of {row.n:.0f} verdicts with this confidence were." in first


def test_the_published_check_is_the_one_of_the_documents():
    page = (Path(__file__).parents[2] / "docs/blind.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| (\d\.\d)-(\d\.\d) \| (\d+) \| ([\d.]+) \| ([\d.]+) \|$", page, re.M)
    kept = [(r.p_low, r.p_high, r.n, r.mean_p, r.share_right) for r in published().reliability]
    assert kept == [tuple(map(float, row)) for row in listed] and len(kept) >= 5
    assert f"Seal {published().seal};" in page and f"{published().cases} cases" in page


def test_the_first_screen_has_no_jargon():
    document = made.diagnosis()
    document["verdict"]["why"] = "adding pulley_friction gains 391891 nats"
    first, rest = shown(document).split("<svg", 1)
    assert "nats" not in first and "Why, in numbers: adding pulley_friction gains 391891 nats." in rest


def test_tables_spell_small_numbers_units_and_names():
    document = made.diagnosis()
    document["downstream"] = {"tracking": [{"reference": "sinusoid", "rmse_without_n": 0.3, "rmse_with_n": 2.1e-15}]}
    document["verdict"]["would_have_shown"] = [{"effect": "pulley_friction", "size": 0.02, "unit": "1", "gap_n": 0.11}]
    document["candidates"][0]["parameters"].append({"name": "load_mm_per_n", "unit": "mm/N", "estimate": 0.3, "ci95": [0.2, 0.4]})
    html = shown(document)
    text = words_of(html)
    assert "sinusoid 0.3 < 0.001" in text and "e-15" not in re.sub(r'data-v="[^"]*"', "", html)
    assert "pulley_friction 0.02 0.11" in text
    assert "mm/N how far the load gives way" in text
    # short names stand whole, long ones may be broken behind an underscore
    assert "load_mm_per_n" in html and "load_<wbr>" not in html


@pytest.mark.parametrize("field", ["shrink_why", "shrink_ci95_pct_why", "why"])
def test_nulls_are_shown_with_their_reason(field):
    """Documents of this version have ``shrink_why``."""
    document = made.diagnosis()
    document["verdict"] |= {"confidence": None, "confidence_why": "under a prior of your own"}
    document["gap"] |= {"shrink_ci95_pct": None, field: "one block only"}
    document["candidates"][0]["parameters"][0] |= {"ci95": None, "why": "at its bound"}
    text = words_of(shown(document))
    assert "Not stated: under a prior of your own." in text
    assert "90.7 % less, on recordings kept out of the fit; 96.8 % of the error above the noise floor. No interval: one block only." in text
    assert "at its bound" in text


def test_errors_of_a_fault_of_the_recorder_say_what_they_are_of():
    document = made.diagnosis(("acquisition_faults",))
    document["gap"] |= {"held_out": False, "samples": "all as recorded", "shrink_ci95_pct": None}
    # what others leave of the sound readings stands on no axis beside them
    document["candidates"] = [{**c, "samples": "analysed"} for c in document["candidates"]]
    document["candidates"].append({"id": "acquisition_faults", "samples": "all as recorded", "rmse_held_out_n": 0.5, "probability": 0.95})
    html = shown(document)
    assert "Error of all readings as recorded 0.61 N as given" in words_of(html) and "errors are of samples" in words_of(html)
    ranking = candidates.data(read(Diagnosed, document))
    assert np.isnan([ranking.floor_n, ranking.retuned_n, ranking.candidates[0].rmse_n]).all() and ranking.candidates[1].rmse_n > 0.0
    assert (waterfall.data(read(Diagnosed, document)).axis, waterfall.data(read(Diagnosed, made.diagnosis())).axis) == (
        "RMSE",
        "held-out RMSE",
    )


def test_what_newer_documents_add_is_shown():
    document = made.diagnosis((), "unknown")
    document["unit"] = "V"
    document["remarks"] = ["out exceeds in by 4 %"]
    document["verdict"] |= {
        "leftover": {"where": "sstl RB", "frequency_hz": 12.5, "run": made.HOSTILE},
        "odd_runs": [{"run_id": "run-7", "status": "identified", "effects": ["zero_offset", "viscous"]}],
        "would_have_shown": {"viscous": {"size": 0.02, "gap_n": 0.11}},
    }
    document["candidates"][0] |= {"sensor": "out_sstl", "d2": 31.5, "change": {"z_out_act_n": 0.32}}
    html = shown(document)
    text = words_of(html)
    for part in (
        "out exceeds in by 4 %",
        "frequency hz 12.5",
        "run-7 identified zero_offset, viscous",
        "out_sstl",
        "31.5",
        "z_out_act_n 0.32",
        "0.61 V",
        "gap / V",
        "0.11",
    ):
        assert part in text, part
    assert made.HOSTILE not in html


def test_a_class_that_cannot_be_separated_shows_the_equations_of_its_members():
    document = made.diagnosis(("lag: channel_delay | channel_lowpass",), "identified")
    document["verdict"]["members"] = {"lag: channel_delay | channel_lowpass": ["channel_delay", "channel_lowpass"]}
    document["candidates"][0] |= {"id": "lag: channel_delay | channel_lowpass", "members": ["channel_delay", "channel_lowpass"]}
    html = shown(document)
    assert 'id="effect-channel-delay"' in html and 'id="effect-channel-lowpass"' in html
    assert "Lag: channel delay | channel lowpass." in words_of(html)


def test_none_lists_no_candidates():
    html = shown(made.diagnosis((), "none"))
    assert "Which effect" not in html and ">Candidates<" not in html and "Nowhere: what is left is noise." in html


def test_where_nothing_is_named_nothing_is_drawn_with_the_effect():
    document = made.diagnosis((), "none")
    assert "with_effect_n" in json.dumps(document)
    text = shown(document)
    assert "with effect" not in text and "as given" in text and "measured − base" in text
    assert "with effect" in shown(made.diagnosis())


def test_a_candidate_leads_to_its_equation():
    html = shown(made.diagnosis())
    assert 'href="#effect-pulley-friction"' in html
    entry = html.split('<h3 id="effect-pulley-friction">')[1]
    assert "T+ = T- exp(-zeta m_zeta) - zeta f0" in unescape(entry.split("</p>")[0])


@pytest.mark.parametrize(("value", "text"), [(0.0, "< 0.001"), (3e-9, "< 0.001"), (0.25, "0.25"), (float("nan"), "–")])
def test_small_probabilities_say_so(value, text):
    assert probability(value).text == text


def test_loose_takes_what_there_is():
    assert loose("t", None) is None and loose("t", {}) is None and loose("t", []) is None
    assert [c.text for c in loose("t", ["a", "b"]).rows[1]] == ["b"]
    assert loose("t", [{"gap_n": 1.0}, {"other": [1, 2]}], unit="V").header == [("gap", "V"), ("other", "")]
    assert cell([1, 2.5]).text == "1, 2.5" and listed(["a", "b", "c"], "or") == "a, b or c"

"""The sentence and the lines under it, word by word, for every status."""

from __future__ import annotations

import pytest

from sstl_cli.core.documents.diagnosis import DiagnosisDocument
from sstl_cli.diagnosis import sentence as said_of

GAP = {
    "rmse_base_n": 1.0, "rmse_retuned_n": 0.25, "rmse_with_effect_n": 0.125, "noise_floor_n": None, "held_out": True, "held_out_kind": "trajectory",
    "shrink_pct": 50.0, "shrink_ci95_pct": [40.0, 60.04], "explained_of_reducible_pct": 75.0,
}  # fmt: skip
WHERE = [
    {"system": "act", "phase": "PP", "share_pct": 30.0},
    {"system": "act", "phase": "PB", "share_pct": 10.0},
    {"system": "sstl", "phase": "PP", "share_pct": 24.0},
    {"system": "sstl", "phase": "RB", "share_pct": 5.0},
    # the same place in another band
    {"system": "act", "phase": "PB", "share_pct": 16.0},
    {"system": "sstl", "phase": "RP", "share_pct": 15.0},
]


def made(found):
    """Return a document of the parts that are said, with what else one has to have."""
    rest = {"schema": "sstl.diagnosis/1", "candidates": [], "next_experiment": None}
    where = [{"config_id": None, "rmse_n": 0.1} | place for place in found["where"]]
    analysis = {"rate_hz": 50.0, "samples": 1, "runs": 1, "set_aside": {}, "noise": {}} | (found.get("analysis") or {})
    return DiagnosisDocument.model_validate(rest | found | {"where": where, "analysis": analysis if "analysis" in found else None})


def sentence(found):
    return said_of.sentence(made(found))


def lines(found):
    return said_of.lines(made(found))


def document(status="identified", effects=("viscous",), group=(), confidence=None, **more):
    verdict = {
        "status": status,
        "effects": list(effects),
        "confidence": confidence,
        "ambiguity_group": list(group),
        "why": "it moves",
        **more,
    }
    return {"verdict": verdict, "gap": GAP, "where": WHERE}


def test_the_cause_is_named_with_its_title_and_how_sure_that_is():
    assert sentence(document()) == "The gap comes from viscous drag along the tendon or at its end (viscous)."
    two = document(effects=("viscous", "slack"), confidence=0.904)
    assert (
        sentence(two)
        == "The gap comes from viscous drag along the tendon or at its end (viscous) and slack (right in 90 of 100 such cases)."
    )
    # no library is large enough to promise more
    assert sentence(document(confidence=0.9999)).endswith("(right in 99 of 100 such cases).")


@pytest.mark.parametrize(
    ("share", "begins"),
    [
        (50.0, "The gap comes from viscous"), (None, "The gap comes from viscous"),
        (49.0, "A part of the gap (49 % of the error above the noise floor) comes from viscous"),
        (0.5, "A part of the gap (0 % of the error above the noise floor) comes from viscous"),
        (0.6, "A part of the gap (1 % of the error above the noise floor) comes from viscous"),
        (0.4, "Next to nothing of the gap comes from viscous"), (-20.0, "Next to nothing of the gap comes from viscous"),
    ],
)  # fmt: skip
def test_what_explains_less_than_half_is_not_where_the_gap_comes_from(share, begins):
    found = document()
    found["gap"] = {**GAP, "explained_of_reducible_pct": share}
    assert sentence(found).startswith(begins)
    found["verdict"]["status"] = "ambiguous"
    assert sentence(found).startswith(begins.replace("comes", "comes most likely"))


@pytest.mark.parametrize(
    ("accounted", "begins"),
    [
        (87.4, "87 % of the gap (squared, beyond the noise, with jumps at moments that nobody can foretell) comes from stick-slip"),
        (50.0, "50 % of the gap (squared, beyond the noise, with jumps"),
        (49.9, "A part of the gap (20 % of the error above the noise floor) comes from stick-slip"),
        (None, "A part of the gap (20 % of the error above the noise floor) comes from stick-slip"),
    ],
)
def test_jumps_are_said_to_be_the_gap_only_as_far_as_they_account_for_it(accounted, begins):
    found = document(effects=("stick_slip",))
    found["gap"] = {**GAP, "explained_of_reducible_pct": 20.0, "accounted_pct": accounted}
    assert sentence(found).startswith(begins)
    found["gap"]["explained_of_reducible_pct"] = 60.0
    assert sentence(found).startswith("The gap comes from stick-slip")


def test_what_has_no_name_is_said_where_it_is_likelier_than_any_candidate():
    likely = {"id": "viscous", "probability": 0.4, "rmse_held_out_n": None, "shrink_pct": None, "parameters": [], "identifiability": "weak"}
    for unknown, begins in ((0.3, "The gap comes most likely from"), (0.5, "The gap may come from")):
        found = document("ambiguous", group=("viscous",), probability_unknown=unknown) | {"candidates": [likely]}
        assert sentence(found).startswith(begins) and ("no name here" in sentence(found)) == (unknown > 0.4)
        # of whom nobody knows whether it is the cause nothing is "not told apart"
        assert not any("not told apart" in line for line in lines(found))
    both = document("ambiguous", group=("viscous", "slack"), probability_unknown=0.5) | {"candidates": [likely]}
    assert ", from slack, or from something" in sentence(both)


def test_rivals_are_listed_up_to_four_and_counted_beyond():
    others = ["slack", "presliding", "stribeck", "dwell_aging", "stick_slip", "crosstalk"]
    said = sentence(document("ambiguous", group=["viscous", *others]))
    assert said == (
        "The gap comes most likely from viscous drag along the tendon or at its end (viscous), or from slack, presliding, stribeck, dwell_aging and 2 more: "
        "this data does not rule them out."
    )
    assert "or from slack: this data does not rule it out" in sentence(document("ambiguous", group=["viscous", "slack"]))
    assert sentence(document("ambiguous", group=["viscous"])).endswith("(viscous), but that is not certain.")


def test_nothing_and_not_known_are_said_as_such():
    found = document("none", effects=(), confidence=0.5)
    assert sentence(found).startswith("The simulator already explains the log to its noise floor") and sentence(found).endswith(
        " (right in 50 of 100 such cases)."
    )
    found["gap"] = {**GAP, "known_misfit_n": 0.123, "noise_floor_n": 0.15}
    assert "since the simulator was accepted: it leaves 0.2 N beyond the noise, where it was 0.12 N (right" in sentence(found)
    # as it was accepted it may leave less than re-tuned to what is most likely
    assert "it leaves 0.12 N beyond the noise" in sentence({**found, "gap": {**found["gap"], "rmse_base_n": 0.192}})
    assert "it leaves 0.2 V beyond" in sentence({**found, "unit": "V"})
    # less likely than all that may be there together: a claim would be one too much
    found["verdict"] |= {"probability_none": 0.3, "probability_unknown": 0.3, "why": "none is likely"}
    assert sentence(found).startswith("It is not certain that anything has changed since the simulator was accepted: none is likely (")
    found["gap"] = GAP
    assert sentence(found).startswith("It is not certain that anything is missing: none is likely (")
    found["verdict"]["probability_none"] = 0.4
    assert sentence(found).startswith("The simulator already explains")
    assert sentence(document("unknown", effects=())) == "The cause of the gap is not known: it moves."


def test_nothing_is_missing_only_if_what_wanders_is_noise_of_a_sensor():
    def output(coloured):
        numbers = {"white_n": 0.01, "coloured_n": coloured, "correlation_s": 5.04}
        return {"output": {k: {"estimate": v, "ci95": None} for k, v in numbers.items()}}

    found = document("none", effects=()) | {"analysis": {"theta": {}, "noise": {"act": output(0.0301), "sstl": output(0.009)}}}
    assert sentence(found).endswith("could show, if what the outputs wander by (act 0.03 N for 5 s) is noise of their sensors.")
    unknown = document("unknown", effects=()) | {"analysis": found["analysis"]}
    assert sentence(unknown) == "The cause of the gap is not known: it moves; outputs wander by act 0.03 N for 5 s."
    # as noise of a sensor does
    found["analysis"]["noise"]["act"]["output"]["correlation_s"]["estimate"] = 0.9
    assert "wander" not in sentence(unknown)
    found["analysis"]["noise"]["act"] = output(0.009)
    assert sentence(found).endswith("nothing is missing that this data could show.")


def test_lines_of_a_cause_that_was_found():
    said = lines(document(group=["viscous", "slack"]))
    assert said == [
        "  1 N as given -> 0.25 N re-tuned -> 0.12 N with the effect; noise floor -",
        "  held-out error falls by 50.0 % [40.0, 60.0]; 75.0 % of the error above the noise floor",
        "  it lies in   act PP 30 %   act PB 26 %   sstl PP 24 %   elsewhere 20 %",
        "  not told apart from it on this data: slack",
    ]


def test_what_is_not_known_is_left_out():
    found = document()
    found["gap"] = {**GAP, "held_out": False, "shrink_ci95_pct": None, "explained_of_reducible_pct": None}
    found["where"] = [{"system": "act", "phase": "PP", "share_pct": 100.5}]
    assert lines(found)[1:] == [
        "  error falls (no other excitation to hold out) by 50.0 %",
        "  it lies in   act PP 100 %   elsewhere 0 %",
        "  not told apart from it on this data: nothing",
    ]


@pytest.mark.parametrize(
    ("samples", "of"), [("all as recorded", "all readings as recorded"), ("channel tension_in (N)", "channel tension_in (N)")]
)
def test_an_error_of_other_samples_says_of_which(samples, of):
    """Nothing else to hold out was given as the reason, where other excitation was there."""
    found = document()
    found["gap"] = {**GAP, "held_out": False, "samples": samples, "shrink_ci95_pct": None}
    assert lines(found)[1] == f"  error of {of} falls by 50.0 %; 75.0 % of the error above the noise floor"


def test_an_error_that_rises_is_not_said_to_fall():
    found = document()
    found["gap"] = {**GAP, "shrink_pct": -20.6, "shrink_ci95_pct": [-103.2, 45.5], "explained_of_reducible_pct": -53.3}
    assert lines(found)[1] == "  held-out error rises by 20.6 % [-45.5, 103.2]"


def test_lines_where_nothing_was_found_say_what_would_have_shown_the_smallest_gap_first():
    shown = [{"effect": f"e{i}", "parameter": "k", "size": 0.25, "unit": "N", "gap_n": float(6 - i)} for i in range(5)]
    said = lines({**document("none", effects=(), would_have_shown=shown), "unit": "V"})
    assert said[0] == "  1 V as given -> 0.25 V re-tuned; noise floor -" and said[1].startswith("  it lies in")
    assert said[2:] == [f"  would have shown: e{i} (k) from 0.25 N on, a gap of {6 - i} V" for i in (4, 3, 2, 1)]


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({}, ""),
        ({"rival": "zero_offset", "told_size": 0.5}, "; told from zero_offset from 0.5 N on"),
        ({"rival": "zero_offset", "told_size": 0.25}, "; told from zero_offset"),
        ({"rival": "zero_offset", "told_size": None}, "; not told from zero_offset"),
    ],
)
def test_what_would_have_shown_says_from_what_it_would_have_been_told(told, said):
    shown = [{"effect": "e", "parameter": "k", "size": 0.25, "unit": "N", "gap_n": 0.1, **told}]
    assert (
        lines(document("none", effects=(), would_have_shown=shown))[-1] == f"  would have shown: e (k) from 0.25 N on, a gap of 0.1 N{said}"
    )


def test_what_is_dimensionless_has_no_unit_and_a_gap_below_a_thousandth_says_just_that():
    shown = [{"effect": "pulley_friction", "parameter": "m_p", "size": 0.00068, "unit": "1", "gap_n": 2.5e-7}]
    found = document("none", effects=(), would_have_shown=shown)
    found["gap"] = {**GAP, "rmse_retuned_n": 3.1e-15}
    assert lines(found)[0] == "  1 N as given -> < 0.001 N re-tuned; noise floor -"
    assert lines(found)[-1] == "  would have shown: pulley_friction (m_p) from 0.00068 on, a gap of < 0.001 N"
    found["gap"]["known_misfit_n"] = 1e-9
    assert "it leaves < 0.001 N beyond the noise, where it was < 0.001 N" in sentence(found)


def test_what_is_left_over_is_shown_twice_at_most():
    left = [
        {"test": "mean", "sigma": 7.6, "where": "act PP"},
        {"test": "lag", "sigma": 5.0, "where": ""},
        {"test": "chi2", "sigma": 4.0, "where": ""},
    ]
    assert lines(document("unknown", effects=(), leftover=left))[2:] == [
        "  left over: mean, 8 sigma, at act PP",
        "  left over: lag, 5 sigma",
    ]


@pytest.mark.parametrize(
    ("status", "effects", "said"),
    [
        ("none", [], "nothing is missing"),
        ("unknown", [], "the cause is not known"),
        ("ambiguous", ["viscous", "slack"], "most likely viscous + slack, but not for sure"),
        ("identified", ["viscous"], "viscous"),
    ],
)
def test_a_run_without_which_the_answer_differs_is_named_with_that_answer(status, effects, said):
    odd = [{"run_id": "r7", "status": status, "effects": effects}]
    assert lines(document("none", effects=(), odd_runs=odd))[-1] == f"  without run r7: {said}"


def test_tracking_and_notes_come_last():
    tracked = {"reference": "sinus", "rmse_with_n": 0.1, "rmse_without_n": 0.4}
    said = lines({**document(), "downstream": {"config_id": "a", "tracking": [tracked]}, "notes": ["too short"]})
    assert said[-2:] == ["  a controller that knows it tracks the sinus reference to 0.1 N instead of 0.4 N", "  note: too short"]


def test_effects_that_stand_together_are_listed_together():
    found = document("ambiguous", group=["viscous", "slack", "crosstalk"], causes=[["viscous"], ["crosstalk", "slack"], ["slack"]])
    assert "or from crosstalk + slack, slack: this data" in sentence(found)
    assert lines(found)[3] == "  not told apart from it on this data: crosstalk + slack, slack"


def test_theta_is_that_beside_the_named_effects_and_bends_that_kept_theirs_are_not_listed():
    theta = {
        "theta": {"a": 0.6, "b": 0.7},
        "theta_before": {"a": 0.5, "b": 0.5},
        "theta_with_effect": {"a": 0.501, "b": 0.52},
        "theta_changed": True,
    }
    assert "  theta has changed as well since the simulator was accepted: b 0.5 -> 0.52, +4 %" in lines({**document(), "analysis": theta})
    # also where the cause is not known, and only re-tuning tells
    unknown = lines({**document("unknown", effects=()), "analysis": {**theta, "theta_with_effect": None}})
    assert "  theta has changed since the simulator was accepted: a 0.5 -> 0.6, +20 %, b 0.5 -> 0.7, +40 %" in unknown
    slight = {**theta, "theta_with_effect": {"a": 0.501, "b": 0.501}}
    assert any(x.endswith("accepted: by less than one per cent") for x in lines({**document(), "analysis": slight}))


def test_a_theta_that_more_than_doubles_has_no_per_cent_of_what_it_was():
    theta = {"theta_before": dict.fromkeys("abcd", 0.001), "theta": dict(zip("abcd", (0.202, 0.002, 0.0005, 0.001), strict=True))}
    theta["theta_before"] |= {"e": 0.0}
    theta["theta"] |= {"e": 0.1}
    told = lines({**document(), "analysis": {**theta, "theta_changed": True}})
    changed = "a 0.001 -> 0.202, b 0.001 -> 0.002, +100 %, c 0.001 -> 0.0005, -50 %, e 0 -> 0.1"
    assert f"  theta has changed as well since the simulator was accepted: {changed}" in told


def test_a_share_of_what_is_above_the_known_misfit_says_so():
    """All of the error above the floor was explained, where 2 N were left over a floor of 0.018 N."""
    found = document()
    found["gap"] = {**GAP, "known_misfit_n": 2.1}
    assert "75.0 % of the error above the noise floor and the known misfit" in lines(found)[1]
    found["gap"] |= {"explained_of_reducible_pct": 20.0}
    assert sentence(found).startswith("A part of the gap (20 % of the error above the noise floor and the known misfit) comes from")
    for none in (None, 0.0):
        found["gap"] |= {"known_misfit_n": none}
        assert lines(found)[1].endswith("20.0 % of the error above the noise floor")


def test_what_a_model_is_known_to_leave_stands_beside_the_noise():
    found = document("none", effects=())
    found["gap"] = {**GAP, "noise_floor_n": 0.02, "known_misfit_n": 0.05}
    assert lines(found)[0] == "  1 N as given -> 0.25 N re-tuned; noise floor 0.02 N, known misfit 0.05 N"


def test_a_retuned_model_that_leaves_more_than_the_given_one_says_why():
    found = document("none", effects=())
    found["gap"] = {**GAP, "rmse_base_n": 0.15, "rmse_retuned_n": 0.18, "noise_floor_n": 0.02}
    assert lines(found)[0] == "  0.15 N as given -> 0.18 N re-tuned (to what is most likely, not to the least RMSE); noise floor 0.02 N"
    found["gap"]["rmse_retuned_n"] = 0.1501
    assert lines(found)[0] == "  0.15 N as given -> 0.15 N re-tuned; noise floor 0.02 N"


def test_what_another_channel_shows_is_told_beside_the_cause_of_the_gap():
    loop = {
        "channel": "tension_in", "unit": "N", "effects": ["tension_loop_lag"], "rmse_base": 0.42, "rmse_with_effect": 0.032,
        "shrink_pct": 92.4, "parameters": {"tau_s": 0.16},
    }  # fmt: skip
    told = "  beside the output: lag of the tension loop (tension_loop_lag) explains channel tension_in, whose error falls from 0.42 N to 0.032 N"
    assert told in lines(document() | {"beside": loop})
    # half of the error is what counts as a cause, and the verdict says it itself where it names it
    for found in (document() | {"beside": loop | {"shrink_pct": 49.0}}, document(effects=("tension_loop_lag",)) | {"beside": loop}):
        assert not any("beside the output" in line for line in lines(found))

"""The numbers behind every figure, worked out by hand from small inputs."""

import math
from dataclasses import replace

import matplotlib.colors
import numpy as np
import pytest
from matplotlib.figure import Figure
from reporting_inputs import HOSTILE

from sstl_cli.core.documents.control import ScoreRow
from sstl_cli.core.documents.mapping import ThetaRow
from sstl_cli.core.errors import SstlError
from sstl_cli.core.runs import Run
from sstl_cli.reporting import figures, palette
from sstl_cli.reporting.diagnosed import Diagnosed, Loop, Residuals
from sstl_cli.reporting.documents import read
from sstl_cli.reporting.inputs import Inputs, Segments, command_view, segments, view
from sstl_cli.reporting.rows import Evaluated, columns, epochs, predictions
from sstl_cli.reporting.scored import Scored

FOUND = figures.find()
NAN = float("nan")


def small_run():
    t = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    return view(Run("r", "act", t, np.array([5.0, 10, 15, 12, 6, 5]), np.array([3.0, 6, 9, 9, 9, 7]), config_id="C"))


def small_phases():
    return Segments(np.array([0.0, 3.0, 5.0]), np.array([1, 2, 3], dtype=np.int8))


def theta_row(system, lead, p, r, **more):
    row = {"run_id": f"{system}{lead}", "config_id": f"C{lead}", "system": system, "location": "CP", "lead_mm": lead}
    row |= {"gamma_p": p, "gamma_r": r, "beta_p": -0.5, "beta_r": 0.25, "status": "ok"}
    row |= {"gamma_p_se": 0.03, "gamma_r_se": 0.04, "beta_p_se": 0.1, "beta_r_se": None, "inlier_p": 1.0, "inlier_r": 1.0}
    return ThetaRow(**{**row, "rmse_p_n": 0.1, "rmse_r_n": 0.1, "loops": 1, **more})


def diagnosed(**document):
    return read(Diagnosed, document)


def scored(**document):
    return read(Scored, document)


THETA = [theta_row("act", 0.0, 0.5, 2.0), theta_row("sstl", 0.0, 0.3, 3.0), theta_row("act", 4.0, 0.4, None)]


def view_of(method, error):
    time = np.arange(4.0)
    columns = {"time_s": time, "tension_ref_n": np.full(4, 10.0), "tension_out_n": 10.0 + np.array(error)}
    return command_view("r", method, columns, np.array([0, 1, 1, 3], dtype=np.int8))


VIEWS = [view_of("DI", [0.0, 0, 0, 1]), view_of("none", [2.0, 3, 3, 1])]
PREDICTED = [
    {"location": "NP", "gamma_p_true": 0.5, "gamma_p_pred": 0.53},
    {"location": "CP", "gamma_p_true": 0.6, "gamma_p_pred": 0.56},
    {"location": "CP", "gamma_p_true": None, "gamma_p_pred": 0.56},
]
PREDICTIONS = list(predictions(PREDICTED))
GAP = {"rmse_base_n": 0.6, "rmse_retuned_n": 0.4, "rmse_with_effect_n": None, "noise_floor_n": 0.1}


def check_loop(f):
    found = f.data(small_run(), small_phases(), theta_row("act", 0.0, 0.6, None, beta_p=0.5, beta_r=1.0))
    assert list(found.curves) == ["PP", "RB", "RP"]
    # a stretch between two samples has the phase of its end
    assert found.curves["PP"][0].tolist() == [5, 10, 15]
    assert found.curves["RB"][1].tolist() == [9, 9, 9]
    assert found.curves["RP"][1].tolist() == [9, 7]
    assert found.lines == {"pull": f.Line((5.0, 15.0), pytest.approx((3.5, 9.5)), 0.6, 0.5)}
    return found


def check_time(f):
    found = f.data(small_run(), small_phases())
    assert found.input_n.tolist() == [5, 10, 15, 12, 6, 5]
    assert found.output["RB"][0].tolist() == [2, 3, 4]
    return found


def check_overview(f):
    found = f.data([small_run()] * 7, {"r": small_phases()})
    assert found.span == (5.0, 15.0, 3.0, 9.0) and found.of == 7 and len(found.loops) == 7
    assert f.figure(found)[1] == (2, 6)
    return found


def check_theta(f):
    found = f.data(THETA)
    assert list(found.series) == [("act", "CP"), ("sstl", "CP")]
    act = found.series["act", "CP"]
    assert act.x == [0.0, 4.0] and act.values["gamma_p"] == [0.5, 0.4] and act.errors["gamma_p"] == [0.03, 0.03]
    assert act.values["gamma_r"][0] == 2.0 and math.isnan(act.values["gamma_r"][1]) and math.isnan(act.errors["beta_r"][0])
    no_lead = f.data([row.model_copy(update={"lead_mm": None}) for row in THETA])
    assert not no_lead.by_lead and no_lead.series["sstl", "CP"].x == [1.0]
    return found


def check_squared(f):
    found = f.data([*THETA, theta_row("act", 0.0, 0.7, 2.0)])
    # two act runs of one configuration are averaged: 0.6 squared
    assert found.locations["CP"]["gamma_p"] == f.Points([pytest.approx(0.36)], [0.3])
    assert found.locations["CP"]["gamma_r"] == f.Points([4.0], [3.0])
    return found


def check_product(f):
    found = f.data(THETA)
    assert found.series["act", "CP"].product == [1.0]
    assert found.series["act", "CP"].se == pytest.approx([math.sqrt((2.0 * 0.03) ** 2 + (0.5 * 0.04) ** 2)])
    assert found.series["sstl", "CP"].product == pytest.approx([0.9])
    return found


def check_predicted(f):
    found = f.data(PREDICTIONS).quantities["gamma_p"]
    assert found.groups["CP"] == f.Points([0.6], [0.56])
    assert found.n == 2 and found.rmse == pytest.approx(math.sqrt((0.03**2 + 0.04**2) / 2))
    # errors of two variants taken together are those of no mapping
    two = [{"variant": v, "location": "CP", "gamma_p_true": 0.5, "gamma_p_pred": p} for v, p in (("linear", 0.6), ("skip", 0.5))]
    errors = {k: (q.n, q.rmse) for k, q in f.data(list(predictions(two))).quantities.items()}
    assert errors == {"gamma_p linear": (1, pytest.approx(0.1)), "gamma_p skip": (1, 0.0)}
    other = columns(["true_gamma_r", "pred_gamma_r", "gamma_p", "gamma_p_hat", "x_pred"])
    assert other == {"gamma_p": ("gamma_p", "gamma_p_hat"), "gamma_r": ("true_gamma_r", "pred_gamma_r")}
    return f.data(PREDICTIONS)


def check_residuals(f):
    found = f.data(PREDICTIONS).quantities["gamma_p"]
    assert found.groups["NP"].residual == pytest.approx([0.03])
    assert found.mean == pytest.approx(-0.005)
    return f.data(PREDICTIONS)


def check_variants(f):
    rows = [Evaluated("a", i, 0.01, NAN, v, 0.0) for i, v in enumerate((0.02, 0.04))]
    # the mean prediction over seeds has its own row without a seed: it is no third seed
    found = f.data([*rows, Evaluated("a", None, 0.01, NAN, 0.01, 0.0)])
    assert found.variants["a"]["rmse_total"].mean == pytest.approx(0.03)
    assert found.variants["a"]["rmse_total"].sd == pytest.approx(0.02 / math.sqrt(2))
    assert "rmse_gamma_r" not in found.variants["a"]
    # one seed says nothing of a spread
    alone = f.data(rows[:1])
    assert alone.variants["a"]["rmse_total"].sd is None and "±" not in f.alt(alone)
    # nor is another model of the same variant
    two = f.default(Inputs(evaluation=[replace(row, file=name) for row, name in zip(rows, ("x", "y"), strict=True)]), None)
    assert {k: v["rmse_total"].values for k, v in two.variants.items()} == {"a (x)": [0.02], "a (y)": [0.04]}
    return found


def check_training(f):
    rows = [{"variant": "a", "seed": s, "epoch": e, "train_loss": (s + 1) / (e + 1)} for s in range(3) for e in range(2)]
    found = f.data(list(epochs(rows)))
    curve = f.Curve([0, 1], [2.0, 1.0], [1.0, 0.5], [3.0, 1.5])
    assert found.variants == {"a": {"train_loss": curve}}
    return found


def check_tracking(f):
    found = f.data(VIEWS)
    assert list(found.methods) == ["none", "DI"]
    assert found.methods["none"].error_n.tolist() == [2, 3, 3, 1]
    assert found.methods["none"].rmse_n == pytest.approx(math.sqrt(23 / 4))
    assert found.reference[1].tolist() == [10.0] * 4
    # compensate names one run a method: they are compared as one
    named = [replace(v, run_id=f"C-sine-{v.method}") for v in VIEWS]
    both = f.default(Inputs(command=named), None)
    assert both.run == "C-sine" and list(both.methods) == ["none", "DI"]
    assert list(f.default(Inputs(command=named), "C-sine-DI").methods) == ["DI"]
    return found


def check_phase_error(f):
    found = f.data([*VIEWS, view_of("none", [4.0, NAN, NAN, 1])])
    none = found.rmse_n["none"]
    assert none["PB"] == pytest.approx(math.sqrt((4 + 16) / 2)) and none["PP"] == 3.0 and none["RP"] == 1.0
    assert math.isnan(none["RB"])
    return found


def check_methods(f):
    errors = (("DI", 0.2), ("none", 4.0), ("none", 5.0))
    rows = [ScoreRow.model_construct(method=m, window="all", rmse_n=v) for m, v in errors]
    found = f.data(rows)
    assert found.windows["all"] == {"none": f.Method([4, 5], 4.5), "DI": f.Method([0.2], 0.2)}
    assert list(found.windows["all"]) == ["none", "DI"]
    return found


def check_waterfall(f):
    found = f.data(diagnosed(gap=GAP))
    assert [s.name for s in found.steps] == ["as given", "re-tuned", "noise floor"]
    assert [s.change_n for s in found.steps] == [None, pytest.approx(-0.2), pytest.approx(-0.3)]
    return found


def check_where(f):
    weights = np.arange(1.0, 41.0)
    cells = [
        {"system": s, "phase": p, "config_id": f"C{c:02d}", "share_pct": 100 * weights[c] / (8 * weights.sum())}
        for s in ("sstl", "act")
        for p in ("RP", "PP", "PB", "RB")
        for c in range(40)
    ]
    found = f.data(diagnosed(where=cells))
    assert found.rows == [f"{s} {p}" for s in ("act", "sstl") for p in ("PB", "PP", "RB", "RP")]
    assert found.columns == [*(f"C{c}" for c in range(26, 40)), "26 others"]
    # however many configurations are summed, all cells still add up to 100 %
    assert np.sum(found.share_pct) == pytest.approx(100.0) == found.total_pct
    assert found.share_pct[0][-1] == pytest.approx(100 * weights[:26].sum() / (8 * weights.sum()))
    return found


def check_candidates(f):
    rows = [{"id": "b", "probability": 0.2, "rmse_held_out_n": 0.3}, {"id": "c"}, {"id": "a", "probability": 0.8}]
    found = f.data(diagnosed(candidates=rows, gap=GAP, verdict={"effects": ["a"]}))
    assert [(c.id, c.named) for c in found.candidates] == [("a", True), ("b", False), ("c", False)]
    assert found.candidates[1].rmse_n == 0.3 and found.floor_n == 0.1 and found.retuned_n == 0.4
    return found


def check_simulated(f):
    loop = {"run_id": "r", "tension_in_n": [1, 2, 3], "measured_n": [1, 2, 2], "base_n": [2, 3, 3], "with_effect_n": [1]}
    found = f.data(read(Loop, loop))
    assert list(found.curves) == ["measured", "base"] and found.rmse_n == {"base": 1.0}
    return found


def check_misfit(f):
    record = {"run_id": "r", "time_s": [0, 1], "tension_in_n": [5, 6], "base_n": [0.3, -0.4], "effect_n": [0.0, None]}
    found = f.data(read(Residuals, record), "V")
    assert found.rmse_n == pytest.approx({"base": math.sqrt(0.125), "with effect": 0.0})
    assert found.time_s.tolist() == [0, 1] and f.figure(found)[1] == (1, 2)
    # a document without residuals has those of its loops, without a clock
    loop = {"run_id": "r", "tension_in_n": [5, 6], "measured_n": [3, 3], "base_n": [2, 5], "with_effect_n": [3, 3]}
    made = f.default(Inputs(diagnosis=[diagnosed(loops=[loop])]), "r")
    assert made.curves["base"].tolist() == [1, -2] and made.time_s is None and f.figure(made)[1] == (1, 1)
    return found


def check_isolability(f):
    found = f.data(diagnosed(isolability={"ids": ["a", "b", "c"], "cosine": [[1, 0.2, -0.99], [0.2, 1, 0], [-0.99, 0, 1]]}))
    assert found.twins == [("c", "a", -0.99)]
    with pytest.raises(SstlError, match="E604"):
        f.data(diagnosed(isolability={"ids": ["a", "b"], "cosine": [[1, 2]]}))
    return found


def check_confusion(f):
    found = f.data(scored(confusion={"labels": ["none", "a"], "matrix": [[3, 1], [0, 4]]}))
    assert found.share_pct == [[75.0, 25.0], [0.0, 100.0]] and found.right_pct == 87.5
    assert "none named a (1)" in f.alt(found)
    return found


def check_reliability(f):
    bins = [{"mean_p": 0.5, "share_right": 0.6, "n": 10}, {"mean_p": 0.9, "share_right": None, "n": 0}]
    found = f.data(scored(reliability=bins, ece=0.1))
    assert [(b.mean_p, b.share_right, b.n) for b in found.bins] == [(0.5, 0.6, 10.0)] and found.ece == 0.1
    return found


def check_distance(f):
    rate = {"k": 3, "n": 4, "low": 0.3, "high": 0.95}
    rows = [{"d2_median": 50.0, "isolation": rate, "in_group": 1.0}, {"d2_median": -1e-9, "isolation": 0.1}, {"d2_median": None}]
    found = f.data(scored(by_d2=rows))
    # a refit may end a hair beyond the truth: no distance is below 0
    assert found.rates["isolation"] == f.Points([0.0, 50.0], [0.1, 0.75], [0.1, 0.3], [0.1, 0.95], [pytest.approx(NAN, nan_ok=True), 4.0])
    assert found.rates["in_group"].d2 == [50.0] and "ideal 1.00" in f.alt(found)
    return found


def check_strength(f):
    rows = [{"strength": 4, "isolation": 0.9}, {"strength": 0.4, "isolation": {"k": 3, "n": 4, "low": 0.3, "high": 0.95}}]
    found = f.data(scored(by_strength=rows)).scores
    assert set(found) == {"isolation"} and found["isolation"].strength == [0.4, 4.0]
    assert found["isolation"].share == [0.75, 0.9]
    assert found["isolation"].low == [0.3, 0.9] and found["isolation"].high == [0.95, 0.9]
    return f.data(scored(by_strength=rows))


def check_baselines(f):
    rows = [{"name": "x", "isolation": 0.5}, {"name": "y", "isolation": {"k": 1, "n": 4}}]
    found = f.data(scored(baselines=rows))
    assert found == f.Bars(["x", "y"], {"isolation": [0.5, 0.25]})
    return found


def check_shrink(f):
    rows = [{"predicted_pct": 80, "realised_pct": 70}, {"predicted_pct": 60, "realised_pct": 64}, {"predicted_pct": 1}]
    found = f.data(scored(shrink=rows))
    assert found.predicted_pct == [80, 60] and found.off_pct == 7.0
    return found


CHECKS = {name.removeprefix("check_"): check for name, check in list(globals().items()) if name.startswith("check_")}


def test_every_figure_has_a_check():
    assert set(CHECKS) == set(FOUND)


@pytest.mark.parametrize("name", sorted(FOUND))
def test_numbers_and_drawing(name):
    module = FOUND[name]
    found = CHECKS[name](module)
    size, grid = module.figure(found)
    figure = Figure(figsize=size)
    axes = figure.subplots(*grid, squeeze=False)
    module.draw(axes[0, 0] if grid == (1, 1) else axes, found)
    for panel in axes.flat:
        # words alone (phases, names) need no unit; every numeric axis has one after a slash
        for axis in (panel.xaxis, panel.yaxis):
            text = axis.get_label().get_text()
            shared = panel.figure.get_supxlabel() + panel.figure.get_supylabel()
            ticks = [t.get_text() for t in axis.get_ticklabels()]
            worded = any(t and not t.replace("−", "").replace(".", "").isdigit() for t in ticks) or not any(ticks)
            assert "/" in text or "/" in shared or worded, (name, text, ticks)
    assert len(module.alt(found)) > 20


def test_segments_join_equal_phases():
    found = segments(np.arange(6.0), np.array([1, 1, 2, 2, 2, 1], dtype=np.int8))
    assert found.start_s.tolist() == [0, 2, 5] and found.code.tolist() == [1, 2, 1]
    assert found.at(np.array([-1.0, 0.5, 4.9, 9])).tolist() == [-1, 1, 2, 1]


def test_sampling_is_measured_at_full_rate():
    t = np.arange(5000) * 0.01
    t[3000:] += 0.5
    tension = np.sin(t)
    tension[7] = NAN
    found = view(Run("r", "act", t, tension, tension))
    assert len(found.time_s) < 5000 == found.samples
    assert found.gap_s == pytest.approx(0.51) and found.missing == 1
    assert found.remark.startswith("1 samples without a value; gap of 0.51 s")


def test_colours_are_okabe_ito_and_told_apart():
    okabe_ito = {"#000000", "#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7"}
    for group in (palette.PHASES, palette.METHODS, palette.LOCATIONS):
        assert len(set(group.values())) == len(group) and set(group.values()) <= okabe_ito
        assert all(matplotlib.colors.is_color_like(c) for c in group.values())
    assert palette.of("XX", palette.LOCATIONS, ["CP", "XX", "YY"]) != palette.of("YY", palette.LOCATIONS, ["CP", "XX", "YY"])
    assert palette.of("NP", palette.LOCATIONS, [HOSTILE]) == palette.LOCATIONS["NP"]


def test_scales_say_where_the_numbers_lie():
    import json

    from sstl_cli.reporting.scales import scales

    figure = Figure(figsize=(4, 2))
    left, right = figure.subplots(1, 2)
    left.plot([0, 10], [-1, 1])
    left.set_xlim(0, 10)
    left.set_xlabel("time / s")
    left.set_yscale("symlog")
    right.bar([0, 1], [2, 3])
    right.set_xticks([0, 1], ["a", "b"])
    right.set_ylim(1, 100)
    right.set_yscale("log")
    figure.draw_without_rendering()
    one, two = json.loads(scales(figure))
    assert one["y"] is None
    assert one["x"] == {"label": "time / s", "from": 0.0, "to": 10.0, "log": False}
    # names have no values in between; left, top, right, bottom in points of a 288 x 144 picture
    assert two["x"] is None and two["y"] == {"label": "", "from": 1.0, "to": 100.0, "log": True}
    assert 0 < one["box"][0] < one["box"][2] < two["box"][0] < 288 and 0 < one["box"][1] < one["box"][3] < 144
    left.set_axis_off()
    right.set_axis_off()
    assert scales(figure) == ""

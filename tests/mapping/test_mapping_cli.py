import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from mapping_data import rows, with_tendons, write
from program import inside
from scipy import stats

from sstl_cli.core.parquet import open_table
from sstl_cli.core.tables import EVALUATION
from sstl_cli.mapping.relations import relations


def sstl(*words, code=0):
    done = inside(*words)
    assert done.returncode == code, done.stderr + done.stdout
    assert "Traceback" not in done.stderr
    return done


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("mapping")
    write(path / "theta.parquet", rows(12))
    sstl(
        "train",
        path / "theta.parquet",
        "-o",
        path / "m.safetensors",
        "--seeds",
        3,
        "--epochs",
        40,
        "--history",
        path / "h.parquet",
        "--json",
    )
    return path


def test_train_and_evaluate_held_out_configurations(folder, tmp_path):
    done = sstl(
        "evaluate",
        folder / "m.safetensors",
        "--theta",
        folder / "theta.parquet",
        "--json",
        "--out",
        tmp_path / "e.parquet",
        "--predictions",
        tmp_path / "p.parquet",
    )
    document = json.loads(done.stdout)
    assert document["schema"] == "sstl.evaluate/1" and document["pairs"] == 9
    found = open_table(tmp_path / "e.parquet", EVALUATION).table().to_pylist()
    assert len(found) == 5 * 4
    predicted = pq.read_table(tmp_path / "p.parquet").to_pylist()
    # by hand from the predictions: the mean over seeds of the default variant
    own = [r for r in predicted if r["variant"] == document["default"]]
    square = [np.mean([(r[f"{q}_pred"] - r[f"{q}_true"]) ** 2 for r in own]) for q in ("gamma_p", "gamma_r")]
    assert document["rmse_total"] == pytest.approx(np.sqrt(np.mean(square)), rel=1e-9)
    row = next(r for r in found if r["variant"] == document["default"] and r["seed"] is None)
    assert row["rmse_gamma_r"] == pytest.approx(np.sqrt(square[1]))
    for row in found:
        assert row["rmse_total"] ** 2 == pytest.approx((row["rmse_gamma_p"] ** 2 + row["rmse_gamma_r"] ** 2) / 2)
    totals = {v: [r["rmse_total"] for r in found if r["variant"] == v and r["seed"] is not None] for v in ("linear", "skip")}
    pair = next(c for c in document["comparisons"] if (c["a"], c["b"]) == ("linear", "skip"))
    assert pair["p_t"] == pytest.approx(stats.ttest_rel(totals["linear"], totals["skip"]).pvalue, rel=1e-6)
    assert pair["p_holm"] >= pair["p_t"]


def test_history_covers_every_network_and_seed(folder):
    history = pq.read_table(folder / "h.parquet")
    assert json.loads(history.schema.metadata[b"sstl"])["schema"] == "sstl.history"
    found = {(r["variant"], r["seed"]) for r in history.to_pylist()}
    assert found == {(v, s) for v in ("plain", "plain-inv", "skip", "skip-inv") for s in range(3)}


def test_the_gate_ends_with_code_4(folder):
    call = ("evaluate", folder / "m.safetensors", "--theta", folder / "theta.parquet", "--max-rmse")
    assert "E513" in sstl(*call, "1e-5", code=4).stderr


def test_what_is_said_of_the_default_is_what_the_gate_judges(folder, tmp_path):
    """The mean of the seeds' errors was said, and that of their mean prediction judged."""
    model = tmp_path / "n.safetensors"
    sstl("train", folder / "theta.parquet", "-o", model, "--variants", "skip", "--seeds", 3, "--epochs", 5)
    call = ("evaluate", model, "--theta", folder / "theta.parquet")
    total = json.loads(sstl(*call, "--json").stdout)["rmse_total"]
    assert f"errs by {total:.3g} in the slopes" in sstl(*call).stdout


def test_new_configurations_outside_the_range_are_told(folder, tmp_path):
    new = rows(4, seed=5)
    for row in new:
        row["config_id"] = "new-" + row["config_id"]
        if row["system"] == "sstl":
            row["gamma_p"] *= 0.5
    write(tmp_path / "new.parquet", new)
    done = sstl("evaluate", folder / "m.safetensors", "--theta", tmp_path / "new.parquet")
    assert "12 of 12 inputs (100 %) lie outside the trained range" in done.stderr


def test_trained_configurations_are_not_judged_unless_asked(folder, tmp_path):
    done = sstl("evaluate", folder / "m.safetensors", "--theta", folder / "theta.parquet", "--all", "--json")
    assert json.loads(done.stdout)["pairs"] == 36
    header = sstl(
        "train",
        folder / "theta.parquet",
        "-o",
        tmp_path / "m.safetensors",
        "--variants",
        "linear",
        "--json",
        "--leave-out",
        "ND",
        "--seeds",
        1,
    )
    assert json.loads(header.stdout)["configurations"]["held_out"] == 12
    left = sstl("evaluate", tmp_path / "m.safetensors", "--theta", folder / "theta.parquet", "--json")
    assert json.loads(left.stdout)["left_out"] == "ND" and json.loads(left.stdout)["pairs"] == 12
    # one seed has no spread over seeds: neither a width of zero nor another
    (only,) = json.loads(left.stdout)["variants"]
    assert set(only["rmse_sd_over_seeds"].values()) == {None}
    shown = sstl("evaluate", tmp_path / "m.safetensors", "--theta", folder / "theta.parquet").stdout
    assert "±" not in shown and "12 pairs, 1 seed\n" in shown
    write(tmp_path / "cp.parquet", rows(12, places=("CP",)))
    line = sstl("evaluate", tmp_path / "m.safetensors", "--theta", tmp_path / "cp.parquet", code=1).stderr
    assert "E506" in line


def test_tables_one_and_two(tmp_path):
    made = rows(40, places=("CP",), scatter=1.0)
    write(tmp_path / "cp.parquet", made)
    document = json.loads(sstl("evaluate", "--theta", tmp_path / "cp.parquet", "--tables", "--json").stdout)
    for direction, name in (("pull", "gamma_p"), ("release", "gamma_r")):
        loop, act = (np.array([r[name] for r in made if r["system"] == s]) for s in ("sstl", "act"))
        line = stats.linregress(act**2, loop)
        got = document["table_i"][direction]
        assert got["pearson_r"] == pytest.approx(line.rvalue) and got["slope"] == pytest.approx(line.slope)
        assert got["bias"] == pytest.approx(line.intercept)
        assert got["identity_rmse"] == pytest.approx(np.sqrt(np.mean((loop - act**2) ** 2)))
        assert got["fit_rmse"] == pytest.approx(np.sqrt(np.mean((loop - line.slope * act**2 - line.intercept) ** 2)))
    loop = np.array([[r["gamma_p"], r["gamma_r"]] for r in made if r["system"] == "sstl"])
    product = document["table_ii"]["sstl"]["product"]
    assert product["mean"] == pytest.approx(loop.prod(1).mean()) and product["std"] == pytest.approx(loop.prod(1).std(ddof=1))
    # the paper: R 0.967 and 0.965, products 0.983 and 0.889
    assert 0.9 < document["table_i"]["pull"]["pearson_r"] < 1
    assert document["table_ii"]["act"]["product"]["mean"] == pytest.approx(0.983, abs=0.01)


def test_relations_of_too_little_data_are_nan_not_errors():
    none, one = relations(np.empty((0, 2)), np.empty((0, 2))), relations([[0.3, 3.0]], [[0.5, 1.7]])
    assert np.isnan(none.slopes["act"]["product"].mean) and np.isnan(one.correlation["pull"].slope)
    assert one.correlation["pull"].identity_rmse == pytest.approx(0.05)


def test_rows_set_aside_end_with_code_3(tmp_path):
    made = rows(6)
    made[0]["gamma_p"] = None
    write(tmp_path / "t.parquet", made)
    done = sstl("train", tmp_path / "t.parquet", "-o", tmp_path / "m.safetensors", "--variants", "linear", "--seeds", 1, code=3)
    assert "2 of 36 rows set aside" in done.stderr and (tmp_path / "m.safetensors").exists()


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["train", "T", "-o", "O", "--variants", "skipp"], 2, "did you mean 'skip'"),
        (["train", "T", "T", "-o", "O"], 2, "E509"),
        (["train", "T", "-o", "O", "--history", "O"], 2, "E109"),
        (["train", "T", "-o", "O", "--leave-out", "NDD"], 1, "did you mean 'ND'"),
        (["train", "SMALL", "-o", "O"], 1, "E502"),
        (["train", "none.parquet", "-o", "O"], 1, "E130"),
        (["train", "T", "-o", "T"], 2, "E109"),
        (["evaluate", "--theta", "T"], 2, "E514"),
        (["evaluate", "--theta", "T", "--tables", "--max-rmse", "1"], 2, "E514"),
        (["evaluate", "T", "--theta", "T"], 1, "E510"),
        (["evaluate", "--theta", "ALONE", "--tables"], 1, "E504"),
    ],
)
def test_wrong_calls_end_in_one_line_and_write_nothing(folder, tmp_path, words, code, text):
    write(tmp_path / "small.parquet", rows(2))
    write(tmp_path / "alone.parquet", [r for r in rows(3) if r["system"] == "act"])
    names = {
        "T": folder / "theta.parquet",
        "O": tmp_path / "o.safetensors",
        "SMALL": tmp_path / "small.parquet",
        "ALONE": tmp_path / "alone.parquet",
    }
    done = sstl(*[names.get(w, w) for w in words], code=code)
    assert text in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not names["O"].exists()


def test_identical_calls_write_identical_bytes(folder, tmp_path):
    found = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        out = tmp_path / name / "m.safetensors"
        words = ("--seeds", 2, "--epochs", 15, "--history", out.with_suffix(".parquet"))
        sstl("train", folder / "theta.parquet", "-o", out, *words)
        found.append((out.read_bytes(), out.with_suffix(".parquet").read_bytes()))
    assert found[0] == found[1]


def test_tendons_from_the_command_line(tmp_path):
    write(tmp_path / "t.parquet", with_tendons(rows(8), 0.1))
    done = sstl("train", tmp_path / "t.parquet", "-o", tmp_path / "m.safetensors", "--seeds", 1, "--epochs", 20, "--json")
    document = json.loads(done.stdout)
    assert document["tendons"] == ["A", "B"] and set(document["strategy_rmse"]) == {"one-hot", "separate"}
    judged = sstl("evaluate", tmp_path / "m.safetensors", "--theta", tmp_path / "t.parquet", "--json")
    assert json.loads(judged.stdout)["pairs"] == 12

import json
import struct
import subprocess
import sys

import numpy as np
import pytest
from mapping_data import BETA, rows, theta, with_tendons
from safetensors.numpy import load_file, save_file

from sstl_cli.core.errors import SstlError
from sstl_cli.mapping import export_onnx, load_model, save_model
from sstl_cli.steps import train as step


@pytest.fixture(scope="module")
def trained():
    return step.run(theta(rows(10)), step.Config(seeds=2, epochs=20))


@pytest.fixture
def path(trained, tmp_path):
    file = tmp_path / "model.safetensors"
    save_model(file, trained.model)
    return file


def notes_of(path):
    raw = path.read_bytes()
    return json.loads(raw[8 : 8 + struct.unpack("<Q", raw[:8])[0]])["__metadata__"]


def again(path, tensors=None, **notes):
    """Write the file anew with other tensors or metadata."""
    kept = {k: v for k, v in {**notes_of(path), **notes}.items() if v is not None}
    save_file(load_file(path) if tensors is None else tensors, path, kept)
    return path


def test_a_model_comes_back_as_it_was(path, trained):
    model = load_model(path)
    x = trained.pairs.sstl
    assert model.header == trained.model.header
    for name in model.header.names:
        np.testing.assert_array_equal(model.predict(x, variant=name), trained.model.predict(x, variant=name))
    assert model.beta_act == pytest.approx(BETA)
    np.testing.assert_allclose(model.members(x).mean(axis=0), model.predict(x))


def test_the_file_says_what_it_was_made_of(path, trained):
    notes = notes_of(path)
    whole = trained.pairs.sstl[[r != "h" for r in trained.model.header.roles[0]]]
    assert json.loads(notes["input_low"]) == whole.min(axis=0).tolist()
    assert json.loads(notes["seeds"]) == [0, 1] and notes["data_sha256"] == trained.pairs.sha256()
    assert json.loads(notes["variants"])[4]["weight_inv"] == 2e-3 and notes["package_version"]


def test_inputs_outside_the_trained_range_are_flagged(trained):
    model = trained.model
    whole = trained.pairs.sstl[[r != "h" for r in model.header.roles[0]]]
    assert not model.outside_range(whole).any()
    low, high = whole.min(axis=0), whole.max(axis=0)
    # both slopes large: inside the box, but the loop's slopes never rise together
    far = np.array([[low[0] - 1e-6, whole[0, 1]], [0.9, 9.0], high, [np.nan, 3.0]])
    assert model.outside_range(far).all() and model.outside is not None
    assert np.isnan(model.predict(far[3:])).all()


def test_prediction_needs_no_torch(path):
    code = (
        "import sys, numpy; from sstl_cli.mapping import load_model; "
        f"load_model({str(path)!r}).predict(numpy.array([[0.25, 3.5]])); sys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_files_that_are_no_model(tmp_path, path):
    raw = path.read_bytes()
    deep = b'{"__metadata__":' + b'{"a":' * 5000 + b"1" + b"}" * 5001
    cases = {
        "empty": b"",
        "short": raw[:5],
        "text": b"not a model at all",
        "truncated": raw[: len(raw) // 2],
        "huge header": struct.pack("<Q", 1 << 62) + raw[8:],
        "header is no object": struct.pack("<Q", 2) + b"[]",
        "nested": struct.pack("<Q", len(deep)) + deep,
        "header cut": raw[:200],
    }
    for name, content in cases.items():
        file = tmp_path / "bad.safetensors"
        file.write_bytes(content)
        with pytest.raises(SstlError) as found:
            load_model(file)
        assert found.value.code in ("E510", "E511"), name
    with pytest.raises(SstlError, match="E130"):
        load_model(tmp_path / "none.safetensors")
    with pytest.raises(SstlError, match="E130"):
        load_model(tmp_path)


@pytest.mark.parametrize(
    "notes",
    [
        {"schema_id": "other"},
        {"schema_version": "2"},
        {"seeds": "[1,"},
        {"seeds": "[0,1,2]"},
        {"default": "deep"},
        {"input_low": "[NaN, 1]"},
        {"reach": None},
        {"roles": '["f","f"]'},
        {"surprise": "1"},
        {"variants": "[]"},
        {"strategy": "separate"},
    ],
)
def test_metadata_that_cannot_be(path, notes):
    with pytest.raises(SstlError, match="E511"):
        load_model(again(path, **notes))


def test_weights_that_cannot_be(path):
    sound = load_file(path)
    key = "0/skip/w1"
    nan = sound[key].copy()
    nan[0, 0, 0, 0] = np.nan
    for change in (
        {key: nan},
        {key: sound[key][:1]},
        {key: sound[key].astype(np.int32)},
        {key: None},
        {"0/x_scale": np.zeros_like(sound["0/x_scale"])},
        {"extra": np.zeros(3)},
    ):
        tensors = {k: v for k, v in {**sound, **change}.items() if v is not None}
        with pytest.raises(SstlError, match="E512"):
            load_model(again(path, tensors))


def test_predict_refuses_another_shape_and_unknown_names(trained):
    for call in (
        lambda m: m.predict(np.zeros(2)),
        lambda m: m.predict(np.zeros((3, 3))),
        lambda m: m.predict(np.zeros((1, 2)), variant="deep"),
    ):
        with pytest.raises(SstlError, match="E505"):
            call(trained.model)


@pytest.mark.parametrize("variant", ["linear", "plain", "skip-inv"])
def test_onnx_agrees_with_predict(path, trained, tmp_path, variant):
    runtime = pytest.importorskip("onnxruntime")
    again(path, default=variant)
    model, out = load_model(path), tmp_path / "model.onnx"
    export_onnx(load_model(path), out)
    x = np.vstack([trained.pairs.sstl, np.random.default_rng(0).uniform([0.1, 1], [0.5, 6], (200, 2))])
    found = runtime.InferenceSession(out).run(None, {"gamma_sstl": x})[0]
    np.testing.assert_allclose(found, model.predict(x), atol=1e-9)
    first = out.read_bytes()
    export_onnx(load_model(path), out)
    assert out.read_bytes() == first


@pytest.mark.parametrize("strategy", ["one-hot", "separate"])
def test_onnx_has_one_output_a_tendon(tmp_path, strategy):
    runtime = pytest.importorskip("onnxruntime")
    data = theta(with_tendons(rows(6), 0.1))
    result = step.run(data, step.Config(seeds=2, epochs=10, strategy=strategy))
    save_model(tmp_path / "m.safetensors", result.model)
    export_onnx(load_model(tmp_path / "m.safetensors"), tmp_path / "m.onnx")
    session = runtime.InferenceSession(tmp_path / "m.onnx")
    x = result.pairs.sstl[:5]
    for output, tendon in zip(session.get_outputs(), "AB", strict=True):
        found = session.run([output.name], {"gamma_sstl": x})[0]
        np.testing.assert_allclose(found, result.model.predict(x, tendon), atol=1e-9)


def test_onnx_without_its_extra_says_what_to_install(path, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "onnx", None)
    with pytest.raises(SstlError, match=r"E520.*sstl-cli\[onnx\]"):
        export_onnx(load_model(path), tmp_path / "m.onnx")
    assert not (tmp_path / "m.onnx").exists()

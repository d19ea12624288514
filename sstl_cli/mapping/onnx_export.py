"""The mapping as an ONNX graph, built straight from the weights: for hosts without Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from sstl_cli.core.errors import SstlError
from sstl_cli.mapping.inference import MappingModel

OPSET = 17
IR_VERSION = 8


def export_onnx(model: MappingModel, out_path: Path | str) -> None:
    """Write the default prediction of a model (mean over seeds of its default variant) as ONNX, in double precision.

    Input ``gamma_sstl`` of shape (n, 2); output ``gamma_act`` of shape (n, 2), or one output
    ``gamma_act_TENDON`` a tendon where the model knows several.

    Raises
    ------
    SstlError
        E520 without the extra ``onnx``; E106 if the file cannot be written.
    """
    try:
        import onnx
    except ImportError:
        raise SstlError("ONNX export needs the package onnx", fix="pip install 'sstl-cli[onnx]'", code="E520") from None
    proto = _graph(onnx, model)
    onnx.checker.check_model(proto)
    try:
        # the same graph gives the same bytes: fields are written in order of their numbers
        Path(out_path).write_bytes(proto.SerializeToString(deterministic=True))
    except OSError as error:
        raise SstlError(f"cannot be written: {error.strerror}", where=str(out_path), code="E106") from None


def _graph(onnx: Any, model: MappingModel) -> Any:
    helper, double = onnx.helper, onnx.TensorProto.DOUBLE
    nodes: list[Any] = []
    constants: list[Any] = []
    outputs: list[Any] = []
    for tendon in model.header.tendons or (None,):
        name = "gamma_act" if tendon is None else f"gamma_act_{tendon}"
        # names inside the graph are numbers: a tendon may be called anything
        builder = _Builder(onnx, f"t{len(outputs)}", nodes, constants)
        builder.member_mean(model, tendon, name)
        outputs.append(helper.make_tensor_value_info(name, double, ["n", 2]))
    source = helper.make_tensor_value_info("gamma_sstl", double, ["n", 2])
    graph = helper.make_graph(nodes, "sstl_mapping", [source], outputs, constants)
    proto = helper.make_model(
        graph,
        opset_imports=[helper.make_opsetid("", OPSET)],
        producer_name="sstl",
        ir_version=IR_VERSION,
        producer_version=model.header.package_version,
    )
    notes = {
        "variant": model.header.default,
        "data_sha256": model.header.data_sha256,
        "input_low": ",".join(map(repr, model.header.input_low)),
        "input_high": ",".join(map(repr, model.header.input_high)),
    }
    helper.set_model_props(proto, notes)
    return proto


class _Builder:
    """Adds nodes and constants under one prefix."""

    def __init__(self, onnx: Any, prefix: str, nodes: list[Any], constants: list[Any]) -> None:
        self.onnx, self.prefix, self.nodes, self.constants = onnx, prefix, nodes, constants
        self.count = 0

    def constant(self, values: np.ndarray) -> str:
        self.count += 1
        name = f"{self.prefix}_c{self.count}"
        self.constants.append(self.onnx.numpy_helper.from_array(np.ascontiguousarray(values, np.float64), name))
        return name

    def node(self, operation: str, *inputs: str, output: str = "", **attributes: Any) -> str:
        self.count += 1
        name = output or f"{self.prefix}_v{self.count}"
        self.nodes.append(self.onnx.helper.make_node(operation, list(inputs), [name], **attributes))
        return name

    def affine(self, x: str, weight: np.ndarray, bias: np.ndarray) -> str:
        """Return ``x W^T + b`` for every member: weight (seeds, out, in), bias (seeds, out)."""
        product = self.node("MatMul", x, self.constant(weight.transpose(0, 2, 1)))
        return self.node("Add", product, self.constant(bias[:, None]))

    def member_mean(self, model: MappingModel, tendon: str | None, output: str) -> None:
        header = model.header
        group = model.groups[model.group_of(tendon)]
        w = {k: v.astype(np.float64) for k, v in group.variants[header.default].items()}
        s = {k: v.astype(np.float64)[:, None] for k, v in group.scaling.items()}
        alpha = header.alpha(header.default)
        # the tendon is fixed in this output, so its indicator columns become part of the bias
        one_hot = np.array(header.one_hot(tendon))
        first, shift = ("a", "c") if alpha is None else ("e_w", "e_b")
        bias = w[shift] + (w[first][:, :, 2:] @ one_hot if len(one_hot) else 0.0)
        x = self.node("Sub", "gamma_sstl", self.constant(s["x_mean"]))
        h = self.affine(self.node("Div", x, self.constant(s["x_scale"])), w[first][:, :, :2], bias)
        if alpha is not None:
            for k in range(w["w1"].shape[1]):
                inner = self.node("Tanh", self.affine(h, w["w1"][:, k], w["b1"][:, k]))
                outer = self.affine(inner, w["w2"][:, k], w["b2"][:, k])
                short = self.node("Mul", h, self.constant(np.array(alpha)))
                h = self.node("Tanh", self.node("Add", outer, short))
            h = self.affine(h, w["h_w"], w["h_b"])
        y = self.node("Add", self.node("Mul", h, self.constant(s["y_scale"])), self.constant(s["y_mean"]))
        self.node("ReduceMean", y, output=output, axes=[0], keepdims=0)

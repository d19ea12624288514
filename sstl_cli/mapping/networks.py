"""A stack of networks that train side by side without touching one another (the one file with layers in torch)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sstl_cli.core.rng import stream
from sstl_cli.mapping.header import weight_shapes
from sstl_cli.mapping.variants import BLOCKS, WIDTH

Parameters = dict[str, Tensor]


def initial(seeds: list[int], inputs: int, dtype: torch.dtype) -> Parameters:
    """Return starting weights, one member a seed: uniform in +-1/sqrt(fan in), the usual rule of linear layers.

    A seed starts the same whatever the variant, so that variants can be compared in pairs.
    """
    shapes = weight_shapes(0.0, 1, inputs)
    fan_in = {"e": inputs, "w": WIDTH, "b": WIDTH, "h": WIDTH}
    found: dict[str, list[Tensor]] = {}
    for seed in seeds:
        rng = stream(seed, "mapping", "weights")
        for name, shape in shapes.items():
            bound = fan_in[name[0]] ** -0.5
            drawn = torch.from_numpy(rng.uniform(-bound, bound, shape[1:])).to(dtype)
            # one tensor a block: a slice of a stack would cost a copy of the stack in the backward pass
            parts = {f"{name}.{k}": drawn[k] for k in range(BLOCKS)} if name[0] in "wb" else {name: drawn}
            for key, value in parts.items():
                found.setdefault(key, []).append(value)
    return {name: torch.stack(values) for name, values in found.items()}


def stacked(p: Parameters) -> dict[str, NDArray[np.floating]]:
    """Return the weights as arrays in the layout of a model file, blocks along the second axis."""
    found: dict[str, list[Tensor]] = {}
    for key, value in p.items():
        found.setdefault(key.split(".")[0], []).append(value)
    return {n: (torch.stack(v, 1) if n[0] in "wb" else v[0]).contiguous().numpy() for n, v in found.items()}


def forward(p: Parameters, x: Tensor, alpha: Tensor) -> Tensor:
    """Return scaled outputs, shape (members, n, 2), for scaled inputs (members, n, d) and alpha (members, 1, 1)."""
    # the embedding has no activation, so W1 of the first block meets its few columns instead of n rows
    first = torch.bmm(p["w1.0"], torch.cat([p["e_w"], p["e_b"].unsqueeze(2)], 2)).transpose(1, 2)
    h = torch.baddbmm(p["e_b"].unsqueeze(1), x, p["e_w"].transpose(1, 2))
    inner = torch.baddbmm((first[:, -1] + p["b1.0"]).unsqueeze(1), x, first[:, :-1])
    h = _close(p, 0, inner, h, alpha)
    for k in range(1, BLOCKS):
        inner = torch.baddbmm(p[f"b1.{k}"].unsqueeze(1), h, p[f"w1.{k}"].transpose(1, 2))
        h = _close(p, k, inner, h, alpha)
    return torch.baddbmm(p["h_b"].unsqueeze(1), h, p["h_w"].transpose(1, 2))


class _Tanh(torch.autograd.Function):
    """tanh as ``2 sigmoid(2 z) - 1``, in place: the library's sigmoid is nine times as fast as its tanh."""

    @staticmethod
    def forward(ctx: Any, z: Tensor) -> Tensor:
        ctx.mark_dirty(z)
        z.mul_(2.0).sigmoid_().mul_(2.0).sub_(1.0)
        ctx.save_for_backward(z)
        return z

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> Tensor:
        (t,) = ctx.saved_tensors
        found: Tensor = torch.ops.aten.tanh_backward(gradient, t)
        return found


_tanh: Callable[[Tensor], Tensor] = _Tanh.apply


def _close(p: Parameters, k: int, inner: Tensor, h: Tensor, alpha: Tensor) -> Tensor:
    """Return ``tanh(W2 tanh(inner) + alpha h)`` of block k."""
    outer = torch.baddbmm(p[f"b2.{k}"].unsqueeze(1), _tanh(inner), p[f"w2.{k}"].transpose(1, 2))
    return _tanh(torch.addcmul(outer, alpha.expand_as(h), h))


def loss(predicted: Tensor, true: Tensor, weight: Tensor, weight_inv: Tensor) -> Tensor:
    """Return Eq. (loss) of every member, shape (members,), on physical slopes of shape (members, n, 2).

    Parameters
    ----------
    weight : tensor, shape (members, n)
        1/N for samples that count, 0 for padding.
    weight_inv : tensor, shape (members,)
        lambda.
    """
    error = ((predicted - true) ** 2).sum(2)
    inverse = (predicted[..., 0] * predicted[..., 1] - 1.0) ** 2
    return ((error + weight_inv.unsqueeze(1) * inverse) * weight).sum(1)

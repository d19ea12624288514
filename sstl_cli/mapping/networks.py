"""A stack of networks that train side by side without touching one another (the one file with layers in torch)."""

from __future__ import annotations

import torch
from torch import Tensor

from sstl_cli.core.rng import stream
from sstl_cli.mapping.header import weight_shapes

Parameters = dict[str, Tensor]


def initial(seeds: list[int], inputs: int, dtype: torch.dtype) -> Parameters:
    """Return starting weights, one member a seed: uniform in +-1/sqrt(fan in), the usual rule of linear layers.

    A seed starts the same whatever the variant, so that variants can be compared in pairs.
    """
    shapes = weight_shapes(0.0, 1, inputs)
    fan_in = {"e": inputs, "w": shapes["w1"][-1], "b": shapes["w1"][-1], "h": shapes["h_w"][-1]}
    found: dict[str, list[Tensor]] = {name: [] for name in shapes}
    for seed in seeds:
        rng = stream(seed, "mapping", "weights")
        for name, shape in shapes.items():
            bound = fan_in[name[0]] ** -0.5
            found[name].append(torch.from_numpy(rng.uniform(-bound, bound, shape[1:])).to(dtype))
    return {name: torch.stack(values) for name, values in found.items()}


def forward(p: Parameters, x: Tensor, alpha: Tensor) -> Tensor:
    """Return scaled outputs, shape (members, n, 2), for scaled inputs (members, n, d) and alpha (members, 1, 1)."""
    # the embedding has no activation, so W1 of the first block meets its few columns instead of n rows
    first = torch.bmm(p["w1"][:, 0], torch.cat([p["e_w"], p["e_b"].unsqueeze(2)], 2)).transpose(1, 2)
    h = torch.baddbmm(p["e_b"].unsqueeze(1), x, p["e_w"].transpose(1, 2))
    inner = torch.baddbmm((first[:, -1] + p["b1"][:, 0]).unsqueeze(1), x, first[:, :-1])
    h = _close(p, 0, inner, h, alpha)
    for k in range(1, p["w1"].shape[1]):
        inner = torch.baddbmm(p["b1"][:, k].unsqueeze(1), h, p["w1"][:, k].transpose(1, 2))
        h = _close(p, k, inner, h, alpha)
    return torch.baddbmm(p["h_b"].unsqueeze(1), h, p["h_w"].transpose(1, 2))


def _close(p: Parameters, k: int, inner: Tensor, h: Tensor, alpha: Tensor) -> Tensor:
    """Return ``tanh(W2 tanh(inner) + alpha h)`` of block k."""
    outer = torch.baddbmm(p["b2"][:, k].unsqueeze(1), torch.tanh(inner), p["w2"][:, k].transpose(1, 2))
    return torch.tanh(torch.addcmul(outer, alpha.expand_as(h), h))


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

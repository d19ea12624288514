"""Table III trained plainly: one network after the other, ``torch.nn`` modules and AdamW."""

from __future__ import annotations

import copy
from typing import NamedTuple

import torch
from torch import Tensor, nn

WIDTH, BLOCKS = 128, 2


class SkipMLP(nn.Module):
    """Embedding, blocks h <- tanh(W2 tanh(W1 h) + alpha h), head."""

    def __init__(self, inputs: int, alpha: float) -> None:
        super().__init__()
        self.alpha = alpha
        self.embedding = nn.Linear(inputs, WIDTH)
        self.first = nn.ModuleList(nn.Linear(WIDTH, WIDTH) for _ in range(BLOCKS))
        self.second = nn.ModuleList(nn.Linear(WIDTH, WIDTH) for _ in range(BLOCKS))
        self.head = nn.Linear(WIDTH, 2)

    def forward(self, x: Tensor) -> Tensor:
        h = self.embedding(x)
        for w1, w2 in zip(self.first, self.second, strict=True):
            h = torch.tanh(w2(torch.tanh(w1(h))) + self.alpha * h)
        return self.head(h)


class How(NamedTuple):
    """How long to train, and how fast."""

    epochs: int
    patience: int
    learning_rate: float
    weight_decay: float


def train(x: Tensor, y: Tensor, xv: Tensor, yv: Tensor, alpha: float, weight_inv: float, seed: int, how: How) -> tuple[SkipMLP, int]:
    """Return the network with the least validation error, and the epochs it took; y is in physical units."""
    torch.manual_seed(seed)
    mean, scale = y.mean(0), y.std(0)
    net = SkipMLP(x.shape[1], alpha)
    optimiser = torch.optim.AdamW(net.parameters(), lr=how.learning_rate, weight_decay=how.weight_decay)
    best, since, kept = float("inf"), 0, copy.deepcopy(net.state_dict())
    used = 0
    for used in range(1, how.epochs + 1):  # noqa: B007
        optimiser.zero_grad()
        out = mean + scale * net(x)
        loss = ((out - y) ** 2).sum(1).mean() + weight_inv * ((out[:, 0] * out[:, 1] - 1.0) ** 2).mean()
        loss.backward()
        optimiser.step()
        with torch.no_grad():
            error = float(((mean + scale * net(xv) - yv) ** 2).sum(1).mean())
        if error < best:
            best, since, kept = error, 0, copy.deepcopy(net.state_dict())
        else:
            since += 1
            if since >= how.patience:
                break
    net.load_state_dict(kept)
    return net, used


def rmse(net: SkipMLP, y: Tensor, xv: Tensor, yv: Tensor) -> float:
    """Return the error of both slopes on the validation part, in physical units; ``y`` is what the network was scaled by."""
    with torch.no_grad():
        return float((((y.mean(0) + y.std(0) * net(xv)) - yv) ** 2).mean().sqrt())

"""Train every variant and seed in one batched run: members lie along a leading axis and never touch one another."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Lock

import numpy as np
import torch
from numpy.typing import NDArray

from sstl_cli.mapping import networks
from sstl_cli.mapping.inference import Group, Weights
from sstl_cli.mapping.linear import fit_linear
from sstl_cli.mapping.split import FIT, VALIDATION, Splits
from sstl_cli.mapping.variants import Variant

Array = NDArray[np.float64]
# members stacked in one tensor: their weights and AdamW's moments then stay in cache
STACK = 20
# epochs between two looks at the validation error
LOOK = 5


@dataclass(frozen=True)
class Options:
    """How networks are trained: AdamW on the whole fit part at once.

    ``patience`` is the number of epochs without a lower validation error after which a member stops; its best
    weights are kept.
    """

    epochs: int = 600
    learning_rate: float = 2e-3
    weight_decay: float = 1e-2
    patience: int = 60
    double: bool = False


@dataclass(frozen=True)
class Curve:
    """Learning curve of one member: epochs, loss on the fit part, squared error on the validation part."""

    variant: str
    seed: int
    epoch: NDArray[np.int64]
    train_loss: Array
    val_loss: Array


@dataclass(frozen=True)
class Fitted:
    """Trained members: weights, learning curves, and by variant the validation RMSE (total) of every seed."""

    group: Group
    curves: tuple[Curve, ...]
    rmse_validation: dict[str, Array]


@dataclass(frozen=True)
class _Part:
    """Samples of one part for every seed, padded to the same count: weight is 1/N, 0 for padding."""

    x: Array
    y: Array
    weight: Array


def fit(
    x: Array,
    y: Array,
    config_id: Sequence[str],
    splits: Splits,
    variants: Sequence[Variant],
    options: Options = Options(),
    advance: Callable[[float], None] | None = None,
) -> Fitted:
    """Train all variants for all seeds of the splits.

    Parameters
    ----------
    x : array, shape (n, d)
        Gamma_p, Gamma_r of the sensing loop, then indicator columns.
    y : array, shape (n, 2)
        Gamma_p, Gamma_r of the actuation tendon.
    config_id : sequence of str
        Configuration of each row.
    advance : callable, optional
        Told the share of the work that was done since it was told last.
    """
    seeds = splits.seeds
    parts = [_part(x, y, splits.mask(config_id, p)) for p in (FIT, VALIDATION, FIT + VALIDATION)]
    scaling = _scaling(x, y, splits.mask(config_id, FIT + VALIDATION))
    fitting, validating, whole = (_Part(_scaled(p.x, scaling), p.y, p.weight) for p in parts)
    found: dict[str, Weights] = {}
    rmse: dict[str, Array] = {}
    curves: list[Curve] = []
    for v in (v for v in variants if v.alpha is None):
        # closed form: the validation part judges a fit without it, the kept weights use all training data
        found[v.name], rmse[v.name] = fit_linear(fitting, validating, whole, scaling)
    nets = [v for v in variants if v.alpha is not None]
    members = [(v, s) for v in nets for s in range(len(seeds))]
    stacks = [members[i : i + STACK] for i in range(0, len(members), STACK)]
    if stacks:
        with _steady() as cores, ThreadPoolExecutor(cores, "mapping", torch.set_num_threads, (1,)) as pool:
            told = _per(advance, len(stacks))
            jobs = [pool.submit(_train, m, seeds, fitting, validating, scaling, options, told) for m in stacks]
            try:
                done = [job.result() for job in jobs]
            except BaseException:
                _STOP.append(True)
                raise
            finally:
                pool.shutdown(cancel_futures=True)
                _STOP.clear()
        weights = {k: np.concatenate([d.weights[k] for d in done]) for k in done[0].weights}
        judged = np.concatenate([d.judged for d in done])
        curves = [c for d in done for c in d.curves]
        for i, v in enumerate(nets):
            own = slice(i * len(seeds), (i + 1) * len(seeds))
            found[v.name] = {k: w[own] for k, w in weights.items()}
            rmse[v.name] = np.sqrt(judged[own] / 2)
    elif advance is not None:
        advance(1.0)
    order = [v.name for v in variants]
    return Fitted(Group(scaling, {n: found[n] for n in order}), tuple(curves), {n: rmse[n] for n in order})


# set while an interrupt unwinds: the workers stop at their next epoch
_STOP: list[bool] = []


@dataclass(frozen=True)
class _Done:
    weights: Weights
    judged: Array
    curves: list[Curve]


def _train(
    members: list[tuple[Variant, int]],
    seeds: Sequence[int],
    fitting: _Part,
    validating: _Part,
    scaling: Weights,
    options: Options,
    advance: Callable[[float], None],
) -> _Done:
    """Train one stack of members until each has stopped or the epochs are over."""
    kind = torch.float64 if options.double else torch.float32
    own = [s for _, s in members]
    tensor = _tensors(members, fitting, validating, scaling, kind)
    p = networks.initial([seeds[s] for s in own], fitting.x.shape[2], kind)
    best = {k: v.clone() for k, v in p.items()}
    optimiser = _optimiser(p, options)
    # positions of the members still in the stack: one that stops leaves it and costs nothing more
    live = np.arange(len(members))
    lowest, since = np.full(len(members), np.inf), np.zeros(len(members), dtype=int)
    even = torch.arange(tensor["wv"].shape[1]) % 2 == 0
    rows: list[list[tuple[int, float, float, float]]] = [[] for _ in members]
    for epoch in range(1, options.epochs + 1):
        optimiser.zero_grad(set_to_none=True)
        out = tensor["mean"] + tensor["scale"] * networks.forward(p, tensor["x"], tensor["alpha"])
        # the sum couples nothing: each member's weights appear in its own term only
        losses = networks.loss(out, tensor["y"], tensor["w"], tensor["inv"])
        losses.sum().backward()
        optimiser.step()
        if epoch % LOOK and epoch != options.epochs:
            continue
        with torch.no_grad():
            out = tensor["mean"] + tensor["scale"] * networks.forward(p, tensor["xv"], tensor["alpha"])
            square = ((out - tensor["yv"]) ** 2).sum(2) * tensor["wv"]
            first, second = ((square * half).sum(1).double().numpy() for half in (even, ~even))
            fitted = losses.detach().double().numpy()
            better = first + second < lowest[live]
            for name, value in p.items():
                best[name][torch.from_numpy(live[better])] = value[torch.from_numpy(better)]
        lowest[live] = np.where(better, first + second, lowest[live])
        since[live] = np.where(better, 0, since[live] + LOOK)
        for k, member in enumerate(live):
            rows[member].append((epoch, fitted[k], first[k], second[k]))
        stay = np.flatnonzero(since[live] < options.patience)
        advance(LOOK / options.epochs)
        if not len(stay) or _STOP:
            break
        if len(stay) < len(live):
            live, keep = live[stay], torch.from_numpy(stay)
            tensor = {k: v[keep] for k, v in tensor.items()}
            p, optimiser = _compact(p, optimiser, keep, options)
    advance(max(0.0, 1.0 - epoch / options.epochs))
    curves, judged = [], np.empty(len(members))
    for k, (v, s) in enumerate(members):
        epochs, fitted, first, second = np.array(rows[k]).T
        curves.append(Curve(v.name, seeds[s], epochs.astype(np.int64), fitted, first + second))
        judged[k] = _judge(first, second)
    return _Done(networks.stacked(best), judged, curves)


def _tensors(
    members: list[tuple[Variant, int]], fitting: _Part, validating: _Part, scaling: Weights, kind: torch.dtype
) -> dict[str, torch.Tensor]:
    """Return the data of a stack, one row a member."""
    own = [s for _, s in members]
    arrays = {"x": fitting.x, "y": fitting.y, "w": fitting.weight, "xv": validating.x, "yv": validating.y, "wv": validating.weight}
    arrays |= {"mean": scaling["y_mean"][:, None], "scale": scaling["y_scale"][:, None]}
    tensor = {n: torch.from_numpy(a[own]).to(kind) for n, a in arrays.items()}
    tensor["alpha"] = torch.tensor([v.alpha for v, _ in members], dtype=kind).reshape(-1, 1, 1)
    tensor["inv"] = torch.tensor([v.weight_inv for v, _ in members], dtype=kind)
    return tensor


def _optimiser(p: networks.Parameters, options: Options) -> torch.optim.AdamW:
    for value in p.values():
        value.requires_grad_(True)
    return torch.optim.AdamW(p.values(), lr=options.learning_rate, weight_decay=options.weight_decay, fused=True)


def _compact(
    p: networks.Parameters, optimiser: torch.optim.AdamW, keep: torch.Tensor, options: Options
) -> tuple[networks.Parameters, torch.optim.AdamW]:
    """Return parameters and optimiser of the members at ``keep``, moments and step count with them."""
    kept = {name: value.detach()[keep] for name, value in p.items()}
    fresh = _optimiser(kept, options)
    for name, value in kept.items():
        old = optimiser.state[p[name]]
        moments = {n: old[n][keep] for n in ("exp_avg", "exp_avg_sq")}
        fresh.state[value] = {"step": old["step"], **moments}
    return kept, fresh


def _judge(first: Array, second: Array) -> float:
    """Return the validation error with each half judged at the epoch that the other half would stop at.

    The least error over epochs would favour networks over the closed form, which has no epoch to choose.
    """
    if not second.any():
        return float(first.min())
    return float(first[second.argmin()] + second[first.argmin()])


@contextmanager
def _steady() -> Iterator[int]:
    """Yield the number of workers while torch computes the same whatever their number: one thread each."""
    before, strict = torch.get_num_threads(), torch.are_deterministic_algorithms_enabled()
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    try:
        yield len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    finally:
        torch.set_num_threads(before)
        torch.use_deterministic_algorithms(strict)


def _per(advance: Callable[[float], None] | None, stacks: int) -> Callable[[float], None]:
    if advance is None:
        return lambda share: None
    lock = Lock()

    def told(share: float) -> None:
        # the stacks report from their own threads
        with lock:
            advance(share / stacks)

    return told


def _part(x: Array, y: Array, mask: NDArray[np.bool_]) -> _Part:
    """Return the rows of each seed's mask, shape (seeds, most, ...)."""
    counts = mask.sum(axis=1)
    # rows that count come first, in order; the padding repeats others with weight 0
    at = np.argsort(~mask, axis=1, kind="stable")[:, : max(int(counts.max()), 1)]
    weight = (np.arange(at.shape[1]) < counts[:, None]) / np.maximum(counts[:, None], 1)
    return _Part(x[at], y[at], weight)


def _scaling(x: Array, y: Array, mask: NDArray[np.bool_]) -> Weights:
    """Return mean and standard deviation of the training part of each seed; a constant column keeps the scale 1."""
    w = mask / mask.sum(axis=1, keepdims=True)
    found: Weights = {}
    for name, values in (("x", x[:, :2]), ("y", y)):
        mean = w @ values
        std = np.sqrt(np.maximum(np.einsum("sn,snj->sj", w, (values[None] - mean[:, None]) ** 2), 0.0))
        found[f"{name}_mean"] = mean
        found[f"{name}_scale"] = np.where(std > 1e-9 * np.abs(mean), std, 1.0)
    return found


def _scaled(x: Array, scaling: Weights) -> Array:
    done = x.copy()
    done[..., :2] = (x[..., :2] - scaling["x_mean"][:, None]) / scaling["x_scale"][:, None]
    return done
